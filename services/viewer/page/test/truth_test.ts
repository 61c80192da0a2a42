import assert from 'node:assert/strict';
import test from 'node:test';
import { setTimeout as pause } from 'node:timers/promises';
import { MapModel } from '../src/model/map_model';
import { type TimedPose, alignTruth, dashes, parseTruth, referenceKeyframes, truthFit } from '../src/model/truth';
import { TrueTrajectory } from '../src/true_trajectory';
import { change, keyframe } from './messages';

const ROWS = Array.from({ length: 240 }, (_, i) => `${10 + i / 10} ${i} 0 0 0 0 0 1`).join('\n');

function frame(timeS: number, x: number, y: number): TimedPose {
  return {
    timestampNs: BigInt(Math.round(timeS * 1e9)),
    pose: { centre: [x, y, 0], rotation: [0, 0, Math.SQRT1_2, Math.SQRT1_2] },
  };
}

test('rows that are no poses are passed over', () => {
  assert.equal(parseTruth('# no\n1 2 3\n\n1 0 0 0 0 0 0 1\nx 0 0 0 0 0 0 1\n').length, 1);
  assert.deepEqual(parseTruth(ROWS).map(({ timeS }) => timeS).slice(0, 2), [10, 10.1]);
});

test('the truth lies where the frames are', () => {
  const truth = parseTruth(ROWS);
  // A quarter turn about z: the truth's x is the island's y.
  const frames = [0, 50, 100, 200].map((i) => frame(10 + i / 10, 7, i + 3));
  const alignment = alignTruth(truth, frames)!;
  const segments = dashes(truth, alignment);
  assert.ok(segments.length > 0 && segments.length % 6 === 0);
  assert.ok(segments.length / 6 < truth.length * 0.6, 'every second dash is left out');
  for (let i = 0; i < segments.length; i += 3) assert.ok(Math.abs(segments[i] - 7) < 1e-6);
  assert.ok(Math.abs(segments[1] - 3) < 1e-6);
});

test('frames of other times say nothing', () => {
  assert.equal(alignTruth(parseTruth(ROWS), [1000, 1001, 1002].map((t) => frame(t, 0, 0))), undefined);
  assert.equal(alignTruth([], [frame(10, 0, 0)]), undefined);
});

test('a camera that stands still has a truth', () => {
  const still = parseTruth('1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n3 0 0 0 0 0 0 1');
  const alignment = alignTruth(still, [1, 2, 3].map((t) => frame(t, 4, 5)))!;
  assert.deepEqual(dashes(still, alignment).slice(0, 3).map(Math.round), [4, 5, 0]);
});

/** A keyframe of ROWS' times, its centre at x. */
function timed(slot: number, index: number, x: number) {
  return { ...keyframe(slot, index, x), timestampNs: BigInt(10_000_000_000 + index * 100_000_000) };
}

function mapOf(count: number): MapModel {
  const model = new MapModel();
  const keyframes = Array.from({ length: count }, (_, i) => timed(1, i, i));
  model.apply([change({ islands: [
    { slot: 1, inGlobalFrame: true, localMapSlots: [1], keyframes },
    { slot: 2, localMapSlots: [2], keyframes: [timed(2, 0, 50)] },
  ] })]);
  return model;
}

test('only keyframes of the reference island say where the truth lies', () => {
  const told = referenceKeyframes(mapOf(4));
  assert.deepEqual(told.map(({ pose }) => pose.centre[0]), [0, 1, 2, 3]);
  assert.deepEqual(referenceKeyframes(new MapModel()), []);
});

/** What a page's truth asks for and shows. */
function watched(text: string, model: MapModel) {
  const seen = { asked: 0, shown: [] as number[] };
  const rest = { truth: async () => (seen.asked++, text) };
  const stage = { truth: { show: (segments: number[]) => void (seen.shown.push(segments.length)) }, invalidate: () => undefined };
  return { seen, truth: new TrueTrajectory(rest, 'lab', stage, () => model, () => undefined, 1) };
}

test('the truth is asked for once, and laid anew when the map has grown', async () => {
  const model = mapOf(8);
  const { seen, truth } = watched(ROWS, model);
  truth.onMap(model);
  await pause(20);
  assert.deepEqual([seen.asked, seen.shown.length], [0, 0], 'nothing while paths are hidden');
  truth.show(true);
  await pause(20);
  truth.onMap(model);
  await pause(20);
  assert.deepEqual([seen.asked, seen.shown.length], [1, 1], 'the same map is not laid twice');
  model.apply([change({ revision: 1n, islands: [{ slot: 1, inGlobalFrame: true, keyframes: [timed(1, 8, 8)] }] })]);
  truth.onMap(model);
  await pause(20);
  assert.deepEqual([seen.asked, seen.shown.length], [1, 2]);
  truth.stop();
});

test('a mission without truth is not asked again', async () => {
  const model = mapOf(8);
  const { seen, truth } = watched('', model);
  truth.show(true);
  await pause(20);
  model.revision = 5n;
  truth.onMap(model);
  await pause(20);
  assert.deepEqual([seen.asked, seen.shown.length], [1, 0]);
  truth.stop();
});

test('no dash crosses a time of which the truth says nothing', () => {
  const rows = [...Array(50).keys()].flatMap((i) => [`${i} ${i} 0 0 0 0 0 1`, `${500 + i} ${500 + i} 0 0 0 0 0 1`]).join('\n');
  const none = { scale: 1, rotation: [0, 0, 0, 1] as [number, number, number, number], translation: [0, 0, 0] as [number, number, number] };
  const segments = dashes(parseTruth(rows), none);
  assert.ok(segments.length > 0);
  for (let i = 0; i < segments.length; i += 6) assert.ok(segments[i + 3] - segments[i] < 2, `a dash from ${segments[i]} to ${segments[i + 3]}`);
});

test('how far the truth lies from the keyframes is counted', () => {
  const truth = parseTruth(ROWS);
  const frames = [0, 50, 100, 200].map((i, n) => frame(10 + i / 10, 7 + (n % 2 ? 0.1 : -0.1), i + 3));
  const fit = truthFit(truth, frames, alignTruth(truth, frames)!);
  assert.equal(fit.common, 4);
  assert.ok(fit.rms > 0.05 && fit.rms < 0.11, String(fit.rms));
});
