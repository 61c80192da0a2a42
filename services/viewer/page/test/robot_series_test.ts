import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { MissionPulseSchema } from '@gen/corbslam/v1/viewer_pb';
import { RobotSeries } from '../src/model/robot_series';

const S = 1_000_000_000n;
const asked = (second: number, tracked: number) => create(MissionPulseSchema, {
  timeNs: BigInt(second) * S, robots: [{ agent: 'a/alpha', status: { tracked: BigInt(tracked), newestFrameAgeS: 0.1, mapPoints: 50n } }],
});

test('tracked frames are counted by the second, also where a robot began anew', () => {
  const series = new RobotSeries();
  for (const [second, tracked] of [[1, 100], [2, 110], [4, 130], [5, 3], [6, 13]]) series.note(asked(second, tracked));
  assert.deepEqual(series.of('alpha').map(({ trackedPerS }) => trackedPerS), [undefined, 10, 10, undefined, 10]);
  assert.equal(series.of('nobody').length, 0);
});

test('a report that is told again says nothing of the time since', () => {
  const series = new RobotSeries();
  const pulse = (second: number, ageS: number) => create(MissionPulseSchema, {
    timeNs: BigInt(second) * S, agents: [{ name: 'a/beta', connected: true, reportAgeS: ageS, report: { tracked: BigInt(second - ageS) * 10n } }],
  });
  for (const [second, ageS] of [[5, 0], [6, 1], [7, 2], [10, 0]]) series.note(pulse(second, ageS));
  assert.deepEqual(series.of('beta').map(({ timeS, trackedPerS }) => [timeS, trackedPerS]), [[5, undefined], [10, 10]]);
});

test('ten minutes are kept', () => {
  const series = new RobotSeries();
  for (let second = 1; second < 2000; second++) series.note(asked(second, second));
  assert.equal(series.of('alpha').length, 600);
});
