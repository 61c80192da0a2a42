import assert from 'node:assert/strict';
import test from 'node:test';
import { decodeMapChange } from '../src/feed/map_change';
import { change, keyframe, points } from './messages';

test('points are read beside the rest of a message', () => {
  const { message, points: [none, columns] } = change({
    version: 1n << 60n, revision: 7n, continues: true,
    islands: [{ slot: 2, keyframes: [keyframe(2, 300, 1)] }, { slot: 1, anew: true, points: points(1, [9, 4, 4_000_000_000]), localMapSlots: [1] }],
  });
  assert.equal(none, undefined);
  assert.deepEqual([...columns!.slots], [1, 1, 1]);
  assert.deepEqual([...columns!.indices], [9, 4, 4_000_000_000]);
  assert.deepEqual([...columns!.positions].filter((_, i) => i % 3 === 0), [9, 4, 4_000_000_000]);
  assert.deepEqual([message.version, message.revision, message.continues], [1n << 60n, 7n, true]);
  assert.equal(message.islands[0].keyframes[0].id?.index, 300);
  assert.deepEqual(message.islands[1].localMapSlots, [1]);
});

test('a message that is cut off is an error, not a loop', () => {
  assert.throws(() => decodeMapChange(Uint8Array.of(50, 200)));
});
