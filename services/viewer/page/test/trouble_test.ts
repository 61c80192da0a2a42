import assert from 'node:assert/strict';
import test from 'node:test';
import { RestError } from '../src/feed/rest';
import { Refresher } from '../src/refresher';
import { requestTrouble } from '../src/trouble';

test('a token that ran out is asked for; a mission that went is no trouble of requests', () => {
  assert.match(requestTrouble(new RestError(401, 'expired at noon')).refused ?? '', /expired at noon/);
  assert.deepEqual(requestTrouble(new RestError(404, 'no mission')), { failed: '' });
  assert.deepEqual(requestTrouble(new RestError(503, 'No room.')), { failed: 'No room.' });
  assert.deepEqual(requestTrouble(new TypeError('Failed to fetch')), { failed: 'Failed to fetch' });
  assert.deepEqual(requestTrouble(undefined), { failed: '' });
});

test('what could not be fetched is told, and so is that it could again', async () => {
  const ends: unknown[] = [];
  let isGood = false;
  const refresher = new Refresher(0, async () => {
    if (!isGood) throw new Error('away');
  }, (error) => ends.push(error));
  const end = async (count: number) => {
    while (ends.length < count) await new Promise((done) => setImmediate(done));
  };
  refresher.want();
  await end(1);
  isGood = true;
  refresher.want();
  await end(2);
  assert.equal((ends[0] as Error).message, 'away');
  assert.equal(ends[1], undefined);
});
