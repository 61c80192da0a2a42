import assert from 'node:assert/strict';
import test from 'node:test';
import { MapModel } from '../src/model/map_model';
import { isUntold, untoldText } from '../src/panels/legend';
import { HEX_A, change, points } from './messages';

function told(numbers: number[], pointObservations: number[]) {
  return change({ islands: [{ slot: 1, localMapSlots: [1], points: points(1, numbers), pointObservations }] });
}

function observations(model: MapModel): Map<number, number> {
  const { blocks } = model.localMap(HEX_A)!.points;
  return new Map(blocks.flatMap(({ indices, observations: seen, count }) =>
    [...indices.subarray(0, count)].map((index, slot): [number, number] => [index, seen[slot]])));
}

test('how many keyframes see a point goes with it, and later numbers count', () => {
  const model = new MapModel();
  const numbers = Array.from({ length: 3000 }, (_, i) => i);
  model.apply([told(numbers, numbers.map((n) => 1 + (n % 200)))]);
  model.apply([told([7, 8], [42, 70_000])]);
  model.apply([change({ islands: [{ slot: 1, removedPoints: { slots: [1], indexDeltas: [0n] } }] })]);
  const seen = observations(model);
  assert.deepEqual([seen.get(7), seen.get(8), seen.get(9), seen.get(2999)], [42, 255, 10, 1 + (2999 % 200)]);
  assert.equal(model.observedPoints, 2999);
  assert.equal(observations(model.copy()).get(2999), seen.get(2999));
  assert.equal(model.copy().observedPoints, 2999);
});

test('a store that does not tell is said to', () => {
  const model = new MapModel();
  model.apply([told([1, 2], [])]);
  assert.ok(isUntold(model));
  assert.match(untoldText(model), /does not tell/);
  model.apply([told([2], [0])]);
  assert.ok(!isUntold(model));
  assert.match(untoldText(model), /1 of which that is not told/);
});

test('numbers that are not one for each point are not believed', () => {
  assert.equal(told([1, 2, 3], [5, 6]).points[0]!.observations, undefined);
});
