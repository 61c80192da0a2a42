import assert from 'node:assert/strict';
import test from 'node:test';
import { LengthPrefixed } from '../src/feed/length_prefixed';
import { hexId, parseKeyframeName } from '../src/model/ids';
import { formatState, parseState } from '../src/view_state';

test('messages are cut wherever the stream was cut', () => {
  const bytes = Uint8Array.of(2, 0, 0, 0, 7, 8, 0, 0, 0, 0, 1, 0, 0, 0, 9);
  for (let cut = 0; cut <= bytes.length; cut++) {
    const cutter = new LengthPrefixed();
    const messages = [...cutter.push(bytes.slice(0, cut)), ...cutter.push(bytes.slice(cut))];
    assert.deepEqual(messages.map((message) => [...message]), [[7, 8], [], [9]]);
    assert.equal(cutter.rest, 0);
  }
});

test('ids are 16 digits, and names are read back', () => {
  assert.equal(hexId(0xabn), '00000000000000ab');
  assert.deepEqual(parseKeyframeName('missions/lab/localMaps/00000000000000ab/keyframes/12'), { localMap: '00000000000000ab', index: 12 });
  assert.equal(parseKeyframeName('missions/lab/localMaps/x/keyframes/12'), undefined);
});

test('the address carries the view', () => {
  const state = parseState('#mission=lab&show=pr&colour=age&layer=both&top=1&robot=beta&hidden=alpha');
  assert.deepEqual([state.points, state.refused, state.keyframes], [true, true, false]);
  assert.deepEqual(parseState(formatState(state)), state);
  assert.equal(parseState('#colour=<script>').colour, 'robot');
});
