import assert from 'node:assert/strict';
import test from 'node:test';
import { type Extent, withPoints } from '../src/model/extent';
import { PointStore } from '../src/model/point_store';
import { Random } from '../src/model/random';

const KEYFRAMES: Extent = { low: [0, 0, 0], high: [10, 1, 1] };

function store(count: number, place: (i: number, unit: () => number) => [number, number, number]): PointStore {
  const random = new Random(5);
  const unit = () => random.below(1_000_000) / 1_000_000;
  const points = new PointStore();
  for (let i = 0; i < count; i++) points.set(i, ...place(i, unit), i, 1);
  return points;
}

test('points around the keyframes widen their extent', () => {
  const points = store(40_000, (_, unit) => [10 * unit(), -8 + 16 * unit(), 30 * unit()]);
  const { low, high } = withPoints(KEYFRAMES, points);
  assert.ok(low[1] < -6 && low[1] >= -8, `low y ${low[1]}`);
  assert.ok(high[1] > 6 && high[1] <= 8, `high y ${high[1]}`);
  assert.ok(high[2] > 25 && high[2] <= 30, `high z ${high[2]}`);
});

test('far outliers do not shrink the map, few or many', () => {
  for (const every of [4, 10, 100, 5000]) {
    const points = store(20_000, (i, unit) => (i % every === 0 ? [1e6 * unit(), 0, 4e6] : [10 * unit(), 0, 5 * unit()]));
    const { low, high } = withPoints(KEYFRAMES, points);
    assert.ok(high[0] <= 10 && low[0] >= 0, `one of ${every}: x ${low[0]} to ${high[0]}`);
    assert.ok(high[2] > 3 && high[2] < 40, `one of ${every}: z to ${high[2]}`);
  }
});

test('a camera that stands still shows the room that it sees', () => {
  const still: Extent = { low: [0, 0, 0], high: [0, 0, 0] };
  const { high } = withPoints(still, store(3000, (_, unit) => [unit() - 0.5, unit() - 0.5, 2 + unit()]));
  assert.ok(high[2] > 2.8 && high[2] <= 3, `z to ${high[2]}`);
});

test('what is no number, and no points at all, change nothing', () => {
  assert.deepEqual(withPoints(KEYFRAMES, new PointStore()), KEYFRAMES);
  assert.deepEqual(withPoints(KEYFRAMES, store(100, () => [NaN, Infinity, 0])), KEYFRAMES);
});
