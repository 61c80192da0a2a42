import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { type MissionEvent, MissionEventSchema } from '@gen/corbslam/v1/events_pb';
import { TrackingState, WhyNoPose } from '@gen/corbslam/v1/agent_service_pb';
import { OverlapVerdict } from '@gen/corbslam/v1/overlap_pb';
import { MapNames } from '../src/model/map_names';
import { bytes, count, eventText, mapText, since, timeOfDay, trackingText, verdictText } from '../src/model/texts';

function said(event: MissionEvent['event'] | object): string {
  return eventText(create(MissionEventSchema, { event: event as never }), new MapNames()).text;
}

test('events are said in words', () => {
  assert.equal(said({ case: 'agentJoined', value: { agent: 'missions/m/agents/alpha' } }), 'alpha joined');
  assert.equal(said({ case: 'trackingLost', value: { agent: 'a/beta', frames: 1 } }), 'beta lost tracking for 1 frame');
  assert.equal(
    said({ case: 'islandsMerged', value: { agents: ['a/x', 'a/y', 'a/z'], localMaps: ['l/1', 'l/2', 'l/3'], ms: 1250 } }),
    'Maps of x, y and z became one (3 local maps, 1.3 s)');
  assert.equal(said({ case: 'loopClosed', value: { overlaps: 2 } }), 'Loop closed by 2 overlaps');
  assert.equal(said({ case: 'loopClosed', value: { overlaps: 0, localMaps: ['l/00000000000000aa'] } }), 'Loop closed in map 0000 by the robot itself');
  assert.equal(said({ case: 'agentLeft', value: { agent: 'a/x', onPurpose: true } }), 'x finished and left');
  assert.equal(said({ case: 'agentLeft', value: { agent: 'a/x' } }), 'x is away: its connection ended');
  const found = { localMap: 0xaan, scale: 0.986, scaleSigma: 0.002 };
  assert.equal(
    said({ case: 'mapContradicted', value: { agent: 'a/x', owner: 'a/y', localMap: 'l/00000000000000aa', found } }),
    'x goes without map 0000: 1.40 % smaller than its camera measures');
  assert.match(said({ case: undefined }), /does not know/);
});

test('every verdict has words', () => {
  for (const verdict of Object.values(OverlapVerdict)) {
    if (typeof verdict === 'number') assert.match(verdictText(verdict), /\.$/);
  }
  assert.match(verdictText(99 as OverlapVerdict), /does not know/);
});

test('numbers are short', () => {
  assert.equal(count(1234567), '1\u2009234\u2009567');
  assert.equal(bytes(48213), '48 kB');
  assert.equal(since(0n, 90_000_000_000n), '1 min');
});

test('the picture is told to those who do not see it', () => {
  const islands = () => new Map([['a', []], ['b', []]]);
  const seen = { islands, agents: () => ['alpha', 'beta'], keyframeCount: 1, pointCount: 1200 };
  assert.equal(mapText(seen), '2 islands, 1 keyframe, 1\u2009200 points of alpha and beta');
  assert.equal(mapText({ ...seen, keyframeCount: 0 }), 'nothing yet');
});

test('what happened on another day has its date', () => {
  const now = new Date(2026, 2, 2, 12).getTime();
  const at = (ms: number) => timeOfDay(BigInt(ms) * 1_000_000n, now);
  assert.equal(at(now), new Date(now).toLocaleTimeString());
  assert.match(at(now - 86_400_000), /1.*,/);
  assert.match(at(new Date(2025, 2, 2).getTime()), /2025/);
});

test('a robot that has no pose says why', () => {
  assert.equal(trackingText({ state: TrackingState.LOST, whyNoPose: WhyNoPose.NOT_RECOGNISED }), 'lost: the place is not recognised');
  assert.equal(trackingText({ state: TrackingState.TRACKING, whyNoPose: WhyNoPose.UNSPECIFIED }), 'tracking');
});
