import assert from 'node:assert/strict';
import test from 'node:test';
import { create, toBinary } from '@bufbuild/protobuf';
import { WatchMapResponseSchema } from '@gen/corbslam/v1/map_store_service_pb';
import { OverlapSchema, OverlapVerdict } from '@gen/corbslam/v1/overlap_pb';
import { MissionPulseSchema, type ViewerMessage } from '@gen/corbslam/v1/viewer_pb';
import { RecordedRest, parseRecording } from '../src/feed/recording';
import { Rest } from '../src/feed/rest';
import type { StreamState } from '../src/feed/stream';
import type { MapChange } from '../src/model/map_change';
import { dashesOfPath } from '../src/model/truth';

const base64 = (bytes: Uint8Array) => Buffer.from(bytes).toString('base64');

function recorded(init: { hasPoints?: boolean; hasPast?: boolean } = {}) {
  return parseRecording(JSON.stringify({
    mission: 'lab', hasPoints: true, hasPast: true, ...init,
    map: [1n, 2n].map((revision) => base64(toBinary(WatchMapResponseSchema, create(WatchMapResponseSchema, { revision })))),
    pulse: base64(toBinary(MissionPulseSchema, create(MissionPulseSchema, { storeAnswers: true }))),
    overlaps: [base64(toBinary(OverlapSchema, create(OverlapSchema, { number: 7n, verdict: OverlapVerdict.ACCEPTED })))],
    truth: [[0, 0, 0, 1, 0, 0, 2, 0, 0]],
  }))!;
}

test('a page without a recording asks its server', () => {
  assert.equal(parseRecording(undefined), undefined);
  assert.equal(parseRecording(''), undefined);
});

test('a recording is told as a mission is, then as its past', async () => {
  (globalThis as { requestAnimationFrame?: unknown }).requestAnimationFrame = (call: () => void) => setTimeout(call, 0);
  const rest = new RecordedRest(recorded());
  const told: MapChange[] = [];
  const states: StreamState[] = [];
  const messages: ViewerMessage[] = [];
  const stream = rest.openStream('lab', {
    onMap: (change) => void told.push(change), onMessage: (message) => void messages.push(message),
    onState: (state) => void states.push(state),
  });
  assert.ok(stream.isBehind);
  while (stream.isBehind) await new Promise((done) => setTimeout(done, 10));
  assert.deepEqual(states, [{ name: 'recorded', note: '' }]);
  assert.equal(messages[0].part.case, 'pulse');
  assert.deepEqual(told.map(({ message }) => message.revision), [1n, 2n]);
  const again: MapChange[] = [];
  await rest.history('lab', true, (change) => void again.push(change));
  assert.equal(again.length, 2);
  assert.equal((await rest.overlaps('lab', true))[0].number, 7n);
  await assert.rejects(rest.keyframe('lab', { localMap: '1', index: 0 }), /holds the map, but not this/);
});

test('a recording offers what it holds', () => {
  const offer = ({ isServed, hasPast }: Rest) => ({ isServed, hasPast });
  assert.deepEqual(offer(new Rest(undefined)), { isServed: true, hasPast: true });
  assert.deepEqual(offer(new RecordedRest(recorded())), { isServed: false, hasPast: true });
  assert.deepEqual(offer(new RecordedRest(recorded({ hasPast: false }))), { isServed: false, hasPast: false });
});

test('a recording without points says so', async () => {
  const state = await new Promise<StreamState>((onState) => {
    new RecordedRest(recorded({ hasPoints: false })).openStream('lab', { onMap: () => {}, onMessage: () => {}, onState });
  });
  assert.match(state.name === 'recorded' ? state.note : '', /^Points are left out/);
});

test('a true path is dashed where it lies', () => {
  const segments = dashesOfPath(recorded().truth[0]);
  assert.deepEqual(segments.slice(0, 6), [0, 0, 0, 1, 0, 0]);
});
