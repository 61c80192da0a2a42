import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { WatchMapResponse_IslandKeyframeSchema } from '@gen/corbslam/v1/map_store_service_pb';
import { MapModel } from '../src/model/map_model';
import { HEX_A, HEX_B, change, keyframe, points } from './messages';

function twoIslands(): MapModel {
  const model = new MapModel();
  model.apply([change({
    islands: [
      { slot: 1, anew: true, inGlobalFrame: true, localMapSlots: [1], keyframes: [keyframe(1, 0, 0), keyframe(1, 1, 1)], points: points(1, [3, 7]) },
      { slot: 2, anew: true, localMapSlots: [2], keyframes: [keyframe(2, 0, 0), keyframe(2, 1, 2)], points: points(2, [5]) },
    ],
  })]);
  return model;
}

test('a picture has its islands, keyframes and points', () => {
  const model = twoIslands();
  assert.equal(model.islands().size, 2);
  assert.equal(model.globalIsland, HEX_A);
  assert.deepEqual([model.keyframeCount, model.pointCount], [4, 3]);
  assert.deepEqual(model.pose({ localMap: HEX_B, index: 1 })?.centre, [2, 0, 0]);
  assert.deepEqual(model.localMap(HEX_A)?.points.position(7), [7, 0, 0]);
  assert.deepEqual(model.agents(), ['alpha', 'beta']);
});

test('a merge moves a local map, forgets what was not told again, and says where it stood', () => {
  const model = twoIslands();
  const changes = model.apply([change({
    revision: 1n, removedIslandSlots: [2],
    islands: [{ slot: 1, inGlobalFrame: true, localMapSlots: [1, 2], keyframes: [keyframe(2, 0, 10), keyframe(2, 1, 12)] }],
  })]);
  assert.equal(model.islands().size, 1);
  assert.equal(model.keyframeCount, 4);
  assert.equal(model.pointCount, 2, 'the point of B was not told in the new island');
  const moved = changes.find(({ localMap }) => localMap === HEX_B);
  assert.deepEqual(moved?.oldFromNew?.translation, [-10, 0, 0]);
  assert.equal(moved?.oldFromNew?.scale, 1);
});

test('an island that begins anew loses what is not told, but only when the change is complete', () => {
  const model = twoIslands();
  model.apply([change({ continues: true, islands: [{ slot: 1, anew: true, localMapSlots: [1], keyframes: [keyframe(1, 1, 5)] }] })]);
  assert.equal(model.keyframeCount, 4, 'nothing goes in between');
  model.apply([change({ islands: [{ slot: 1, localMapSlots: [1], points: points(1, [7]) }] })]);
  assert.deepEqual([model.keyframeCount, model.pointCount], [3, 2]);
  assert.equal(model.pose({ localMap: HEX_A, index: 0 }), undefined);
});

test('a reset keeps the picture until the new one is whole', () => {
  const model = twoIslands();
  model.reset();
  assert.equal(model.keyframeCount, 4);
  model.apply([change({ islands: [{ slot: 1, anew: true, localMapSlots: [1], keyframes: [keyframe(1, 0, 0)] }] })]);
  assert.deepEqual([model.keyframeCount, model.pointCount, model.localMaps.size], [1, 0, 1]);
});

test('removals take away keyframes and points', () => {
  const model = twoIslands();
  model.apply([change({ islands: [{ slot: 1, removedKeyframes: [{ slot: 1, index: 0 }], removedPoints: points(1, [3]).ids }] })]);
  assert.deepEqual([model.keyframeCount, model.pointCount], [3, 2]);
  assert.deepEqual(model.pose({ localMap: HEX_A, index: 1 })?.centre, [1, 0, 0], 'the one that took its slot stays right');
});

test('slots beyond the table and broken poses are passed over', () => {
  const model = new MapModel();
  model.apply([change({ islands: [
    { slot: 9, keyframes: [keyframe(1, 0, 0)] },
    { slot: 1, keyframes: [keyframe(7, 0, 0), { id: { slot: 1, index: 1 }, cameraFromIsland: { rotationWxyz: [1], translation: [] } }] },
  ] })]);
  assert.equal(model.keyframeCount, 0);
});

test('a keyframe keeps all that was told of it but its names and its pose', () => {
  const model = new MapModel();
  const told = create(WatchMapResponse_IslandKeyframeSchema, { ...keyframe(1, 4, 2), placed: true, parent: { slot: 1, index: 3 } });
  const { id, cameraFromIsland, parent, ...rest } = told;
  model.apply([change({ islands: [{ slot: 1, localMapSlots: [1], keyframes: [told] }] })]);
  const { slot, generation, ...kept } = model.localMap(HEX_A)!.keyframes.records.get(4)!;
  assert.deepEqual(kept, rest);
});

test('keyframes are in the order of their time, whatever the order of arrival', () => {
  const model = new MapModel();
  model.apply([change({ islands: [{ slot: 1, localMapSlots: [1], keyframes: [keyframe(1, 9, 9), keyframe(1, 2, 2), keyframe(1, 4, 4)] }] })]);
  const store = model.localMap(HEX_A)!.keyframes;
  assert.deepEqual(store.slotsByTime().map((slot) => store.indices[slot]), [2, 4, 9]);
  assert.equal(store.newest(), 9);
});
