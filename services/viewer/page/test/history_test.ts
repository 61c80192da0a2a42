import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { MissionEventSchema } from '@gen/corbslam/v1/events_pb';
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

test('a moment of a link is found again, though other moments are told by then', () => {
  const history = past(20);
  const link = history.moment(7);
  assert.equal(history.stepOfMoment(link), 7);
  const coarser = new History();
  for (const i of [0, 5, 10, 15]) {
    const island = { slot: 1, localMapSlots: [1], keyframes: Array.from({ length: 5 }, (_, k) => keyframe(1, i + k, i)) };
    coarser.add(change({ revision: BigInt(i), islands: [island] }));
  }
  assert.equal(coarser.stepOfMoment(link), 0);
  assert.equal(coarser.stepOfMoment('99.999'), 3);
  assert.equal(new History().stepOfMoment('1.1'), 0);
});

test('events lie at the first step that shows them', () => {
  const history = past(20);
  const event = (revision: bigint, told: object) => create(MissionEventSchema, { revision, event: told as never });
  assert.equal(history.stepOfEvent(event(9n, { case: 'islandsMerged', value: {} })), 9);
  assert.equal(history.stepOfEvent(event(0n, { case: 'localMapBegun', value: { localMap: 'missions/m/localMaps/00000000000000aa' } })), 0);
  assert.equal(history.stepOfEvent(event(0n, { case: 'agentJoined', value: { agent: 'missions/m/agents/alpha' } })), 0);
  assert.equal(history.stepOfEvent(event(0n, { case: 'agentJoined', value: { agent: 'missions/m/agents/zulu' } })), undefined);
  assert.equal(history.stepOfEvent(event(99n, { case: 'mapAdjusted', value: {} })), undefined, 'it is behind what is told');
});
