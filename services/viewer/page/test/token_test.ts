import assert from 'node:assert/strict';
import test from 'node:test';
import { keepToken, takeToken } from '../src/token';

/** A browser's tab as far as tokens need one. */
function tab(hash: string) {
  const kept = new Map<string, string>();
  const location = { hash };
  const sessionStorage = {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
    removeItem: (key: string) => void kept.delete(key),
  };
  const history = { replaceState: (_: unknown, __: string, url: string) => void (location.hash = url) };
  Object.assign(globalThis, { location, sessionStorage, history });
  return { kept, location };
}

test('a token in the address goes out of it into the tab', () => {
  const { kept, location } = tab('#mission=lab&token=corbslam1.a.b&colour=age');
  assert.equal(takeToken(), 'corbslam1.a.b');
  assert.equal(location.hash, '#mission=lab&colour=age');
  assert.equal(takeToken(), 'corbslam1.a.b', 'the tab keeps it');
  assert.equal(kept.size, 1);
});

test('a token that is given counts from then on, and none forgets it', () => {
  tab('#mission=lab');
  assert.equal(takeToken(), undefined);
  keepToken('first');
  assert.equal(takeToken(), 'first');
  keepToken('');
  assert.equal(takeToken(), undefined);
  tab('#token=');
  assert.equal(takeToken(), undefined, 'an empty one is none');
});
