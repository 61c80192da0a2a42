import assert from 'node:assert/strict';
import test from 'node:test';
import { DirtyPages } from '../src/model/dirty_pages';
import { BLOCK_POINTS } from '../src/model/point_block';
import { PointStore } from '../src/model/point_store';

function filled(count: number): PointStore {
  const store = new PointStore();
  for (let i = 0; i < count; i++) store.set(i, i, 0, 0, i, 1);
  return store;
}

test('points keep their places through insertion, movement and removal', () => {
  const store = filled(3000);
  for (let i = 0; i < 3000; i += 3) store.remove(i);
  for (let i = 1; i < 3000; i += 3) store.set(i, -i, 0, 0, 9e5, 2);
  assert.equal(store.count, 2000);
  assert.deepEqual(store.position(1), [-1, 0, 0]);
  assert.deepEqual(store.position(2999), [2999, 0, 0]);
  assert.equal(store.position(0), undefined);
});

test('a full block is followed by another one', () => {
  const store = filled(BLOCK_POINTS + 5);
  assert.deepEqual(store.blocks.map(({ count }) => count), [BLOCK_POINTS, 5]);
});

test('a prefix of a block is a uniform subsample', () => {
  const [block] = filled(BLOCK_POINTS).blocks;
  const prefix = [...block.indices.subarray(0, BLOCK_POINTS / 8)];
  const early = prefix.filter((index) => index < BLOCK_POINTS / 2).length;
  assert.ok(Math.abs(early - prefix.length / 2) < 120, `${early} of ${prefix.length} are of the first half`);
});

test('a sweep removes what is of an older generation', () => {
  const store = filled(100);
  for (let i = 0; i < 40; i++) store.set(i, 0, 0, 0, 0, 2);
  store.sweep(2);
  assert.equal(store.count, 40);
  assert.ok(store.has(39) && !store.has(40));
});

test('only pages that changed are sent, neighbours together', () => {
  const pages = new DirtyPages(10);
  for (const slot of [3, 12, 45]) pages.mark(slot);
  assert.deepEqual(pages.take(48), [{ start: 0, end: 20 }, { start: 40, end: 48 }]);
  assert.equal(pages.any, false);
});
