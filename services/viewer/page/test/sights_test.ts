import assert from 'node:assert/strict';
import test from 'node:test';
import { create, fromJson } from '@bufbuild/protobuf';
import { KeyframeSchema } from '@gen/corbslam/v1/resources_pb';
import { MapModel } from '../src/model/map_model';
import { highlightText, sightsOf, sightsText, splitLandmarks } from '../src/model/sights';
import { change, points } from './messages';

const keyframe = fromJson(KeyframeSchema, {
  keypoints: 2000, observedPoints: 3,
  sights: [{ keypoint: 0, localMap: '170', point: 7 }, { keypoint: 4, localMap: '170', point: 7 },
    { keypoint: 9, localMap: '18446744073709551615', point: 1 }],
});

test('landmarks that the map has are found, the rest are counted', () => {
  const model = new MapModel();
  model.apply([change({ islands: [{ slot: 1, localMapSlots: [1], points: points(1, [7]) }] })]);
  const sights = sightsOf(keyframe)!;
  assert.deepEqual(sights.landmarks.map(({ localMap }) => localMap), ['00000000000000aa', 'ffffffffffffffff']);
  const { known, missing } = splitLandmarks(sights.landmarks, (id) => model.localMap(id)?.points);
  assert.deepEqual([known[0].position, missing], [[7, 0, 0], 1]);
  assert.equal(sightsText(sights), '3 of 2\u2009000 keypoints see a landmark');
  assert.match(highlightText(sights, missing, false), /^1 of its 2 landmarks .*; 1 this page’s map does not have/);
  assert.match(highlightText(sights, missing, true), /past/);
});

test('a store that does not say which landmarks is not one that says none', () => {
  assert.equal(sightsOf(create(KeyframeSchema, { keypoints: 5, observedPoints: 2 })), undefined);
  assert.deepEqual(sightsOf(create(KeyframeSchema, { keypoints: 5 }))?.landmarks, []);
});
