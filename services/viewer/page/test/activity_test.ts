import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { AgentActivity, MissionAgentSchema } from '@gen/corbslam/v1/resources_pb';
import { contradictionFacts, doingOf, reportFacts } from '../src/model/activity';

const told = (init: object) => create(MissionAgentSchema, { name: 'missions/m/agents/alpha', ...init });
const report = (activity: AgentActivity, more: object = {}) => ({ connected: true, reportAgeS: 2, report: { activity, ...more } });

test('what a robot does is told apart', () => {
  const cases: [object, string, string][] = [
    [report(AgentActivity.TRACKING), 'driving', 'maps'],
    [{ ...report(AgentActivity.TRACKING), localiseOnly: true }, 'localising', 'localises'],
    [report(AgentActivity.LOST), 'lost', 'lost'],
    [report(AgentActivity.INITIALISING), 'standing', 'begins'],
    [report(AgentActivity.WAITING, { newestFrameAgeS: 61 }), 'standing', 'no frames for 1 min'],
    [report(AgentActivity.FINISHED, { newestFrameAgeS: 900 }), 'finished', 'finished, still there'],
    [{ ...report(AgentActivity.TRACKING), reportAgeS: 40 }, 'lost', 'says nothing for 40 s'],
  ];
  for (const [init, doing, words] of cases) assert.deepEqual(doingOf(told(init)), { doing, words });
});

test('a robot that ended is none that broke off', () => {
  assert.deepEqual(doingOf(told({ leftOnPurpose: true }), 300), { doing: 'finished', words: 'finished 5 min ago' });
  assert.deepEqual(doingOf(told({ report: { activity: AgentActivity.TRACKING } }), 300), { doing: 'gone', words: 'broke off 5 min ago' });
});

test('of older robots and stores no more is said than is known', () => {
  assert.deepEqual(doingOf(told({ connected: true })), { doing: 'connected', words: 'connected' });
  assert.deepEqual(doingOf(told({ connected: true, localiseOnly: true })), { doing: 'localising', words: 'localises' });
  assert.deepEqual(doingOf(told({})), { doing: 'gone', words: 'offline' });
  assert.deepEqual(doingOf(undefined), { doing: 'unknown', words: 'not known' });
  assert.deepEqual(doingOf(told(report(99 as AgentActivity))), { doing: 'connected', words: 'connected' });
});

test('frames that were passed over are no lost ones', () => {
  const rows = reportFacts(told(report(AgentActivity.TRACKING, { frames: 1200n, tracked: 900n, dropped: 300n, newestFrameAgeS: 0.2 })));
  assert.deepEqual(rows, [['Frames', '1\u2009200, 100 % tracked'], ['… passed over', '300, they came too fast'], ['Newest frame', '2 s old']]);
  assert.deepEqual(reportFacts(told({ connected: true })), []);
});

test('which maps of others a robot goes without, and why', () => {
  const names = { of: (id: string) => `map ${id}` };
  const contradictions = [
    { localMap: 0xabn, scale: 1.0141, scaleSigma: 0.001 },
    { localMap: 0xacn, scale: 0.98, scaleSigma: 0.001 },
    { localMap: 0xadn, scale: 1, bend: { wayM: 4.52, shiftM: 0.127, turnRad: 0.0122 } },
  ];
  assert.deepEqual(contradictionFacts(told(report(AgentActivity.TRACKING, { contradictions })), names), [
    ['Goes without', 'map 00000000000000ab: 1.41 % larger than its camera measures'],
    ['Goes without', 'map 00000000000000ac: 2.00 % smaller than its camera measures'],
    ['Goes without', 'map 00000000000000ad: bent, over 4.5 m its camera turns otherwise by 0.7°'],
  ]);
  assert.deepEqual(contradictionFacts(told({ connected: true }), names), []);
});
