import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { TrajectoryPoseSchema } from '@gen/corbslam/v1/resources_pb';
import { alignTruth, dashes, parseTruth } from '../src/model/truth';

const ROWS = Array.from({ length: 240 }, (_, i) => `${10 + i / 10} ${i} 0 0 0 0 0 1`).join('\n');

function frame(timeS: number, x: number, y: number) {
  return create(TrajectoryPoseSchema, {
    timestampNs: BigInt(Math.round(timeS * 1e9)),
    frameFromCamera: { rotationWxyz: [Math.SQRT1_2, 0, 0, Math.SQRT1_2], translation: [x, y, 0] },
  });
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
