import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { MissionPulseSchema } from '@gen/corbslam/v1/viewer_pb';
import { Connection } from '../src/connection';

class Sign {
  isLive = false;
  chip = '';
  banner = '';
  showConnection(isLive: boolean, words: string): void { [this.isLive, this.chip] = [isLive, words]; }
  showBanner(words: string): void { this.banner = words; }
}

function begin(hasPicture = true): { sign: Sign; connection: Connection } {
  const sign = new Sign();
  const connection = new Connection(sign, false, () => assert.fail('refused'), () => hasPicture);
  connection.onState({ name: 'connecting' });
  connection.onState({ name: 'open' });
  return { sign, connection };
}

const pulse = (init: object) => create(MissionPulseSchema, { storeAnswers: true, ...init });

test('a page is live once the store has answered, not before', () => {
  const { sign, connection } = begin();
  assert.deepEqual([sign.isLive, sign.chip], [false, 'not live']);
  connection.onPulse(pulse({}));
  assert.deepEqual([sign.isLive, sign.chip, sign.banner], [true, 'live', '']);
  connection.onState({ name: 'silent', forMs: 17_000 });
  assert.equal(connection.isLive, false);
  assert.match(sign.banner, /Nothing has come .* for 17 s\. The picture is as it was/);
  connection.onState({ name: 'open' });
  assert.equal(connection.isLive, false, 'what was said before the silence is not now');
});

test('a mission that is not there is no store that does not answer', () => {
  const { sign, connection } = begin(false);
  connection.onPulse(pulse({ storeAnswers: false, missionMissing: true, storeError: 'there is no mission x' }));
  assert.equal(sign.banner, 'There is no such mission now. The page waits for it.');
  connection.onPulse(pulse({ storeAnswers: false, storeError: 'connection refused' }));
  assert.equal(sign.banner, 'The map store does not answer: nothing listens at its address.');
  connection.onState({ name: 'impossible', reason: 'mission is "a/b", must be letters' });
  assert.equal(sign.banner, 'There can be no such mission: Mission is "a/b", must be letters.');
});

test('of a recording it is said what it lacks', () => {
  const { sign, connection } = begin();
  connection.onState({ name: 'recorded', note: 'Points are left out.' });
  connection.onPulse(pulse({}));
  assert.deepEqual([sign.isLive, sign.chip, sign.banner], [false, 'recorded', 'Points are left out.']);
  connection.onTrouble('No graphics.');
  assert.equal(sign.banner, 'No graphics.');
});

test('the past, damage and requests that fail are said', () => {
  const { sign, connection } = begin();
  connection.onPulse(pulse({ mission: { name: 'missions/m', damage: 'run corbslam journal mend' } }));
  assert.match(sign.banner, /damaged.*not shown: run corbslam journal mend\./);
  connection.onRequests('No room');
  assert.match(sign.banner, /as they were: No room\./);
  connection.onRequests('');
  connection.onPulse(pulse({}));
  connection.onPast(true);
  assert.deepEqual([sign.isLive, sign.chip], [false, 'the past']);
  assert.equal(connection.isLive, true, 'robots are told as they are now');
});
