import assert from 'node:assert/strict';
import test from 'node:test';
import type { Offer } from '../src/feed/rest';
import { type KeyActions, handleKey } from '../src/keyboard';
import { parseState } from '../src/view_state';

class Element {}
Object.assign(globalThis, {
  document: { querySelector: () => null }, HTMLElement: Element, HTMLInputElement: class extends Element {}, HTMLSelectElement: class extends Element {},
});

const SERVED: Offer = { isServed: true, hasPast: true };
const ENDED: Offer = { isServed: false, hasPast: false };

/** What a key does: whether it meant something, what it changed, and whether it played the past. */
function press(key: string, offer: Offer): { handled: boolean; changed: object; played: boolean } {
  let changed = {};
  let played = false;
  const ignore = () => {};
  const actions: KeyActions = {
    change: (part) => void (changed = part), play: () => void (played = true), step: () => false, selectRobot: ignore, fit: ignore,
    escape: ignore, help: ignore, measure: ignore, find: ignore,
  };
  const handled = handleKey({ key, target: null } as KeyboardEvent, parseState('#mission=lab'), actions, offer);
  return { handled, changed, played };
}

test('keys ask a server for what it can tell', () => {
  assert.deepEqual(press('e', SERVED).changed, { frames: true });
  assert.deepEqual(press('v', SERVED).changed, { layer: 'local' });
  assert.ok(press(' ', SERVED).played);
});

test('in a recording keys of what it does not hold mean nothing', () => {
  for (const key of ['e', 'E', 'v', 'V', ' ']) assert.deepEqual(press(key, ENDED), { handled: false, changed: {}, played: false }, key);
  assert.deepEqual(press('p', ENDED).changed, { points: false });
  assert.ok(press(' ', { isServed: false, hasPast: true }).played);
});
