import assert from 'node:assert/strict';
import test from 'node:test';
import { plainText } from '../src/model/plain_text';

test('what gRPC says becomes what it means', () => {
  const cases: [string, string][] = [
    ['failed to connect to all addresses; last error: UNKNOWN: ipv4:127.0.0.1:50051: Failed to connect to remote host: Connection refused', 'nothing listens at its address'],
    ['GetMission: Deadline Exceeded', 'it takes too long to answer'],
    ['ListAgents: DNS resolution failed for store.lan: C-ares status is not ARES_SUCCESS: unknown host, grpc', 'its name leads nowhere'],
    ['WatchMap: Socket closed', 'the connection broke'],
    ['UNAVAILABLE: failed to connect to all addresses', 'it can’t be reached'],
    ['Ssl handshake failed: SSL_ERROR_SSL: certificate verify failed', 'the two do not accept each other’s certificates'],
    ['UNIMPLEMENTED: ', 'what answers there is another program, or an older version'],
    ['ListMissions: ', 'it does not say why'],
  ];
  for (const [told, meant] of cases) assert.equal(plainText(told), meant, told);
});

test('what is in words stays', () => {
  for (const words of ['there is no mission x', 'This store wants a token.', 'another page is told a mission’s past; try again soon',
    'Its certificate of 3 May has expired']) assert.equal(plainText(words), words);
  assert.equal(plainText('GetKeyframe: there is no keyframe 7'), 'there is no keyframe 7');
});
