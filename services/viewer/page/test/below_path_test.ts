import assert from 'node:assert/strict';
import test from 'node:test';
import { Rest } from '../src/feed/rest';
import { streamAddress } from '../src/feed/stream';

test('the stream is asked for beside the page', () => {
  assert.equal(streamAddress('https://robots.example/map/#mission=lab&token=t', 'lab'), 'wss://robots.example/map/stream/missions/lab?points=1');
  assert.equal(streamAddress('http://127.0.0.1:8080/', 'a b'), 'ws://127.0.0.1:8080/stream/missions/a%20b?points=1');
  assert.equal(streamAddress('http://host/a/b/index.html', 'lab'), 'ws://host/a/b/stream/missions/lab?points=1');
});

test('requests are relative, so that a path before them stays', async () => {
  const asked: string[] = [];
  const before = globalThis.fetch;
  globalThis.fetch = (async (path: string) => {
    asked.push(new URL(path, 'https://robots.example/map/').pathname);
    return new Response('{}', { status: 200 });
  }) as typeof fetch;
  try {
    const rest = new Rest(undefined);
    await rest.missions();
    await rest.overlaps('lab', true);
    await rest.keyframe('lab', { localMap: '00000000000000aa', index: 3 });
    await rest.truth('lab');
  } finally {
    globalThis.fetch = before;
  }
  assert.deepEqual(asked, ['/map/api/missions', '/map/api/missions/lab/overlaps',
    '/map/api/missions/lab/localMaps/00000000000000aa/keyframes/3', '/map/api/missions/lab/truth']);
});
