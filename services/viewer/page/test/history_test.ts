import assert from 'node:assert/strict';
import test from 'node:test';
import { History } from '../src/model/history';
import { change, keyframe } from './messages';

function past(steps: number): History {
  const history = new History();
  for (let i = 0; i < steps; i++) {
    const island = { slot: 1, localMapSlots: [1], keyframes: [keyframe(1, i, i)] };
    history.add(change({ revision: BigInt(i), continues: true, islands: [island] }));
    history.add(change({ revision: BigInt(i), islands: [] }));
  }
  return history;
}

test('a revision is all of its messages', () => {
  assert.equal(past(4).steps.length, 4);
});

test('going forward and back shows the map as it was', () => {
  const history = past(37);
  for (const step of [36, 3, 25, 24, 0, 36]) {
    history.seek(step);
    assert.equal(history.model.keyframeCount, step + 1);
    assert.equal(history.model.revision, BigInt(step));
  }
});

test('beyond the ends there is nothing', () => {
  const history = past(5);
  history.seek(99);
  assert.equal(history.position, 4);
  history.seek(-3);
  assert.equal(history.position, 0);
  assert.deepEqual(new History().seek(1), []);
});
