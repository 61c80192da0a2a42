import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { TrajectoryPoseSchema } from '@gen/corbslam/v1/resources_pb';
import { drivenPaths, segmentsOf } from '../src/model/driven';
import { KeyframeStore } from '../src/model/keyframe_store';
import { usualStep } from '../src/model/step';
import { type Way, wayOf } from '../src/model/way';
import { frustumSize } from '../src/scene/keyframes_view';

/** Around a corner: 60 m ahead, then 60 m to the right; a frame each metre, a keyframe each second. */
const placeOf = (i: number): [number, number, number] => (i < 60 ? [0, 0, i] : [i - 60, 0, 60]);
const yawOf = (i: number) => (i < 60 ? 0 : Math.PI / 2);

/** Of the keyframes that the drive made, those that are left. */
function left(indices: number[], place = placeOf): KeyframeStore {
  const store = new KeyframeStore();
  for (const index of indices) {
    const yaw = yawOf(2 * index);
    const rotation: [number, number, number, number] = [0, Math.sin(yaw / 2), 0, Math.cos(yaw / 2)];
    store.set(index, { timestampNs: BigInt(2 * index), pose: { centre: place(2 * index), rotation }, placed: true }, index, 1);
  }
  return store;
}

const ALL = Array.from({ length: 60 }, (_, i) => i);
const FEW = [0, 1, 2, 18, 42, 58, 59];

function frames(gaps: number[] = [], without: (i: number) => boolean = () => false) {
  const poses = Array.from({ length: 120 }, (_, i) => create(TrajectoryPoseSchema, {
    agent: 'missions/m/agents/alpha', timestampNs: BigInt(i), localMap: 'missions/m/localMaps/00000000000000aa',
    island: 'missions/m/localMaps/00000000000000aa', afterGap: gaps.includes(i),
    frameFromCamera: { rotationWxyz: [1, 0, 0, 0], translation: placeOf(i) },
  }));
  return drivenPaths(poses.filter((_, i) => !without(i))).localMaps.get('00000000000000aa')!;
}

/** How far the way runs beside the two streets, at most. */
function farthest({ points, count, begins }: Way): number {
  let most = 0;
  for (let i = 1; i < count; i++) {
    if (begins.includes(i)) continue;
    for (let t = 0; t <= 1; t += 0.05) {
      const [x, z] = [0, 2].map((k) => points[3 * i - 3 + k] * (1 - t) + points[3 * i + k] * t);
      const first = Math.hypot(x, Math.max(0, z - 60));
      const second = Math.hypot(Math.min(0, x), z - 60);
      most = Math.max(most, Math.min(first, second));
    }
  }
  return most;
}

test('a robot’s own keyframes are joined, around corners, too', () => {
  const way = wayOf(left(ALL));
  assert.deepEqual(way.begins, [0]);
  assert.equal(way.hasGaps, false);
  assert.equal(wayOf(left([])).count, 0);
});

test('what is left of a thinned session is not joined through a corner', () => {
  const way = wayOf(left(FEW));
  assert.ok(way.hasGaps);
  assert.ok(farthest(way) < 2, `${farthest(way)}`);
});

test('where frames are known, a thinned session’s path is as it was driven', () => {
  const way = wayOf(left(FEW), frames());
  assert.deepEqual(way.begins, [0]);
  assert.ok(farthest(way) < 2);
  assert.ok(way.count > 60, `${way.count}`);
});

test('where frames were lost in between, the gap stays', () => {
  const way = wayOf(left(FEW), frames([50], (i) => i > 40 && i < 50));
  assert.equal(way.begins.length, 2);
  assert.ok(farthest(way) < 2);
});

test('a robot that was lost and came back elsewhere did not go there in a straight line', () => {
  const way = wayOf(left(ALL, (i) => (i < 40 ? placeOf(i) : [i + 200, 0, 60])));
  assert.deepEqual(way.begins, [0, 20]);
});

test('frames before the first keyframe that is left and behind the last one belong to the path', () => {
  const way = wayOf(left([20, 21, 22, 23]), frames());
  assert.deepEqual([...way.points.subarray(0, 3)], [0, 0, 0]);
  assert.deepEqual([...way.points.subarray(3 * way.count - 3, 3 * way.count)], [59, 0, 60]);
  assert.deepEqual(way.begins, [0]);
});

test('keyframes that went leave the usual step and the frusta as they were', () => {
  assert.equal(usualStep(left(ALL)), 2);
  assert.ok(Math.abs(usualStep(left(FEW)) - 2) < 0.2);
  assert.ok(Math.abs(frustumSize(left(ALL)) - 1.2) < 1e-6);
  const few = frustumSize(left([0, 18, 42, 58]));
  assert.ok(few < 3.1, `${few}`);
});

test('a robot that turned on the spot for long has no gaps where it drives on', () => {
  const store = new KeyframeStore();
  for (let i = 0; i < 100; i++) {
    const z = i < 70 ? 0.005 * i : 0.35 + 0.5 * (i - 69);
    store.set(i, { timestampNs: BigInt(i), pose: { centre: [0, 0, z], rotation: [0, 0, 0, 1] }, placed: true }, i, 1);
  }
  assert.deepEqual(wayOf(store).begins, [0]);
});

test('runs that only localised are paths of no local map, each with its gaps', () => {
  const pose = (run: bigint, i: number, afterGap = false) => create(TrajectoryPoseSchema, {
    agent: 'missions/m/agents/loc', run, timestampNs: BigInt(i), afterGap, island: 'missions/m/localMaps/00000000000000aa',
    frameFromCamera: { rotationWxyz: [1, 0, 0, 0], translation: [i, 0, 0] },
  });
  const { localMaps, runs } = drivenPaths([pose(1n, 0), pose(1n, 1), pose(1n, 2, true), pose(1n, 3), pose(2n, 0), pose(2n, 1)]);
  assert.equal(localMaps.size, 0);
  assert.deepEqual(runs.map((run) => [run.agent, segmentsOf(run).length / 6]), [['loc', 2], ['loc', 1]]);
});
