import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { KeyframeSchema } from '@gen/corbslam/v1/resources_pb';
import { driftBetween, driftText, wayAlong } from '../src/model/drift';
import { KeyframeStore } from '../src/model/keyframe_store';
import { type Quat, type Vec3, conjugate, multiply, normalised, rotate } from '../src/model/vector';

const ISLAND_FROM_LOCAL = { scale: 2.5, rotation: normalised([0.2, -0.4, 0.1, 0.8]), translation: [30, -4, 7] as Vec3 };

const wxyz = ([x, y, z, w]: Quat) => [w, x, y, z];

/** camera_from_frame of a camera at a place; `scale` is that of camera_from_frame. */
function cameraFrom(centre: Vec3, rotation: Quat, scale = 1) {
  const inverse = conjugate(rotation);
  const turned = rotate(inverse, centre);
  return { rotationWxyz: wxyz(inverse), translation: turned.map((value) => -scale * value) };
}

/** A keyframe at `centre` of its local map; in the island it is off by `off`. */
function keyframe(centre: Vec3, rotation: Quat, off: Vec3 = [0, 0, 0], island = 'missions/m/localMaps/a') {
  const { scale, rotation: turn, translation } = ISLAND_FROM_LOCAL;
  const moved = rotate(turn, centre).map((value, i) => scale * value + translation[i] + off[i]) as Vec3;
  const back = 1 / scale;
  return create(KeyframeSchema, {
    island, cameraFromLocal: cameraFrom(centre, rotation),
    cameraFromIsland: { ...cameraFrom(moved, multiply(turn, rotation), back), scale: back },
  });
}

const FIRST = keyframe([1, 2, 3], normalised([0.1, 0.3, 0, 0.9]));
const TURNED = normalised([0, 0.7, 0.1, 0.5]);

test('a local map that was turned, scaled and moved as a whole has no drift', () => {
  assert.ok(driftBetween(FIRST, keyframe([40, -3, 60], TURNED))! < 1e-9);
});

test('the drift is how far the newest keyframe is from where the first one puts it', () => {
  assert.ok(Math.abs(driftBetween(FIRST, keyframe([40, -3, 60], TURNED, [3, 0, -4]))! - 5) < 1e-9);
});

test('keyframes of two islands, or without poses, have none', () => {
  assert.equal(driftBetween(FIRST, keyframe([4, 0, 0], TURNED, [0, 0, 0], 'missions/m/localMaps/b')), undefined);
  assert.equal(driftBetween(FIRST, create(KeyframeSchema, { island: FIRST.island })), undefined);
});

test('it is said in metres and of the way', () => {
  const store = new KeyframeStore();
  [[0, 0, 0], [3, 4, 0], [3, 4, 95]].forEach((centre, i) =>
    store.set(i, { timestampNs: BigInt(i), pose: { centre: centre as Vec3, rotation: [0, 0, 0, 1] }, placed: true }, i, 1));
  assert.equal(wayAlong(store), 100);
  assert.equal(driftText({ distanceM: 1.25, wayM: 100 }), '1.25 m in 100 m');
  assert.equal(driftText({ distanceM: 12.34, wayM: 0 }), '12.3 m');
  assert.equal(driftText(undefined), 'not yet');
});
