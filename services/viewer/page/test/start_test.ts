import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { MissionSchema } from '@gen/corbslam/v1/resources_pb';
import { byUse, nowText } from '../src/panels/start';

const NOW_MS = new Date(2026, 2, 2, 12).getTime();
const mission = (name: string, init: object = {}) => create(MissionSchema, { name: `missions/${name}`, ...init });
const ns = (agoS: number) => BigInt(NOW_MS - 1000 * agoS) * 1_000_000n;

test('the list says who drives now, and when a mission was last used', () => {
  assert.match(nowText(mission('a', { connectedAgents: 1, createdNs: ns(60) }), NOW_MS), /^1 robot connected now · begun /);
  assert.equal(nowText(mission('a', { lastUsedNs: ns(7200) }), NOW_MS), 'last used 2 h 0 min ago');
  assert.equal(nowText(mission('a'), NOW_MS), '', 'an older store tells neither');
});

test('missions that are driven in come first, then those that were used last', () => {
  const all = [mission('b'), mission('old', { lastUsedNs: ns(900) }), mission('a'), mission('new', { lastUsedNs: ns(3) }), mission('now', { connectedAgents: 2 })];
  assert.deepEqual(all.sort(byUse).map(({ name }) => name.slice(9)), ['now', 'new', 'old', 'a', 'b']);
});
