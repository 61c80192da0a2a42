import assert from 'node:assert/strict';
import test from 'node:test';
import { History } from '../src/model/history';
import { timeOfDay } from '../src/model/texts';
import { change, keyframe } from './messages';

function past(times: [slot: number, timestampNs: bigint][]): History {
  const history = new History();
  times.forEach(([slot, timestampNs], i) => history.add(change({
    revision: BigInt(i), islands: [{ slot, localMapSlots: [slot], keyframes: [{ ...keyframe(slot, i, i), timestampNs }] }],
  })));
  return history;
}

function timesOf(history: History): (string | undefined)[] {
  return history.steps.map((step, i) => {
    history.seek(i);
    return step.time;
  });
}

test('a clock without dates is told from that robot’s first keyframe', () => {
  assert.deepEqual(timesOf(past([[1, 5_000_000_000n], [1, 7_500_000_000n]])),
    ['newest keyframe 0.0 s after the first by the robots’ clocks', 'newest keyframe 2.5 s after the first by the robots’ clocks']);
});

test('clocks of several robots are not compared', () => {
  const times = timesOf(past([[2, 9_000_000_000_000n], [1, 1_000_000_000n], [1, 4_000_000_000n]]));
  assert.equal(times[2], 'newest keyframe 3.0 s after alpha’s first by the robots’ clocks');
});

test('a clock with dates is told as date and time', () => {
  const ns = 1_764_000_000_000_000_000n;
  assert.deepEqual(timesOf(past([[1, ns], [1, ns - 5_000_000_000n]])),
    [0, 1].map(() => `newest keyframe ${timeOfDay(ns)} by the robots’ clocks`));
});
