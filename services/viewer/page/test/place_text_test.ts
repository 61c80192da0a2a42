import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { SimilaritySchema } from '@gen/corbslam/v1/geometry_pb';
import { distanceText, headingText, placeOf, positionText } from '../src/model/place_text';

/** camera_from_island of a camera at a place that looks so far to the right. */
function camera(centre: number[], yawDeg: number, scale = 1) {
  const half = (yawDeg * Math.PI) / 360;
  const [c, s] = [Math.cos(2 * half), Math.sin(2 * half)];
  const [x, y, z] = centre;
  return create(SimilaritySchema, {
    rotationWxyz: [Math.cos(half), 0, -Math.sin(half), 0], scale,
    translation: [-(c * x - s * z) * scale, -y * scale, -(s * x + c * z) * scale],
  });
}

test('a keyframe is said where it is and where it looks', () => {
  const place = placeOf(camera([3, -1, 40], 30))!;
  assert.equal(positionText(place), '3.00, −1.00, 40.00 m');
  assert.equal(headingText(place), '30.0° right, level');
  assert.equal(headingText(placeOf(camera([0, 0, 0], -90))!), '90.0° left, level');
  assert.equal(headingText(placeOf(camera([0, 0, 0], 0))!), 'ahead, level');
});

test('a map of another unit than its robot’s is told in the island’s', () => {
  assert.equal(positionText(placeOf(camera([3, -1, 40], 30, 2.5))!), '3.00, −1.00, 40.00 m');
});

test('what is no motion has no place', () => {
  assert.equal(placeOf(undefined), undefined);
  assert.equal(placeOf(create(SimilaritySchema, { scale: 1 })), undefined);
  assert.equal(placeOf(create(SimilaritySchema, { rotationWxyz: [1, 0, 0, 0], translation: [NaN, 0, 0], scale: 1 })), undefined);
  assert.equal(placeOf(create(SimilaritySchema, { rotationWxyz: [1, 0, 0, 0], translation: [0, 0, 0], scale: 0 })), undefined);
});

test('a distance has its parts along the ground and of height', () => {
  assert.equal(distanceText([0, 0, 0], [3, 12, 4]), '13.00 m: 5.00 m along the ground, 12.00 m of height');
});
