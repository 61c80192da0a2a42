import assert from 'node:assert/strict';
import test from 'node:test';
import { type InterleavedBufferAttribute, type Sphere } from 'three';
import { KeyframeStore } from '../src/model/keyframe_store';
import { Detail, pathTolerance, worthDrawing } from '../src/scene/detail';
import { enclose } from '../src/scene/enclose';
import { KeyframeTile } from '../src/scene/keyframe_tile';
import { KeyframesView } from '../src/scene/keyframes_view';
import { SharedUniforms } from '../src/scene/materials';
import { simplify } from '../src/scene/simplify';
import { TILE_KEYFRAMES, spreadOrder } from '../src/scene/tile_order';

const MILLION = 1_000_000;

/** Keyframes a unit apart along x. */
function along(count: number): KeyframeStore {
  const store = new KeyframeStore();
  for (let i = 0; i < count; i++) put(store, i, i);
  return store;
}

function put(store: KeyframeStore, index: number, x: number): void {
  store.set(index, { timestampNs: BigInt(index), pose: { centre: [x, 0, 0], rotation: [0, 0, 0, 1] }, placed: true }, index, 1);
}

function viewOf(store: KeyframeStore): KeyframesView {
  const uniforms = new SharedUniforms();
  const view = new KeyframesView(store, uniforms.keyframes(), uniforms.lines());
  view.sync(store);
  return view;
}

/** The x of the frusta that are drawn, tile by tile. */
function drawn(view: KeyframesView): number[] {
  return view.frusta.children.flatMap((child) => {
    const { geometry } = child as KeyframeTile['object'];
    return Array.from({ length: geometry.drawRange.count / 16 }, (_, i) => geometry.getAttribute('place').getX(5 * i));
  });
}

/** Of a map of a million points and 10,000 keyframes that moves, after some frames. */
function shareAfter(frames: number, ms: number, detail = new Detail(1)) {
  for (let i = 0; i < frames; i++) detail.took(ms);
  return detail.share(true, MILLION, 10_000);
}

test('all is drawn while nothing moves, whatever a frame takes', () => {
  const detail = new Detail();
  shareAfter(20, 900, detail);
  assert.deepEqual(detail.share(false, MILLION, 10_000), { points: 1, keyframes: 1, pixels: 1 });
});

test('slow frames of a moving map have fewer points and keyframes, down to what always is drawn', () => {
  assert.deepEqual(shareAfter(1, 38), { points: 0.5, keyframes: 0.5, pixels: 1 });
  for (const ms of [900, 2500, 60_000]) assert.deepEqual(shareAfter(2, ms), { points: 0.02, keyframes: 0.025, pixels: 0.5 }, `${ms}`);
});

test('the first picture has a tenth of a large map', () => {
  assert.deepEqual(shareAfter(0, 0, new Detail()), { points: 0.1, keyframes: 0.1, pixels: 1 });
});

test('one frame that was late by chance takes away no more than half', () => {
  assert.deepEqual(shareAfter(1, 200), { points: 0.5, keyframes: 0.5, pixels: 1 });
});

test('fast frames bring back what slow ones left out', () => {
  const detail = new Detail();
  shareAfter(10, 900, detail);
  assert.deepEqual(shareAfter(100, 16, detail), { points: 1, keyframes: 1, pixels: 1 });
});

test('fewer pixels are drawn where fewer points do not help, and all come back with the points', () => {
  const detail = new Detail();
  assert.equal(shareAfter(20, 50, detail).pixels, 1);
  assert.equal(shareAfter(1, 70, detail).pixels, 0.5);
  assert.equal(shareAfter(10, 16, detail).pixels, 0.5);
  assert.equal(shareAfter(60, 16, detail).pixels, 1);
});

test('of a small map no points and keyframes are left out in a hurry', () => {
  const detail = new Detail();
  shareAfter(20, 50, detail);
  assert.deepEqual(detail.share(true, 40_000, 900), { points: 1, keyframes: 1, pixels: 1 });
  shareAfter(1, 70, detail);
  assert.deepEqual(detail.share(true, 10_000, 250), { points: 1, keyframes: 1, pixels: 0.5 });
});

test('what is far off is drawn in part', () => {
  assert.equal(worthDrawing(512, 1, 1, 0.25, 16), 17);
  assert.equal(worthDrawing(512, 1, 1000, 0.25, 16), 512);
  assert.equal(worthDrawing(512, 0.1, Infinity, 0.25, 16), 52);
});

test('each prefix of a tile is spread over the way', () => {
  for (const count of [TILE_KEYFRAMES, 300, 7, 1, 0]) {
    const order = spreadOrder(count);
    assert.deepEqual([...order].sort((a, b) => a - b), Array.from({ length: count }, (_, i) => i));
  }
  const eighth = [...spreadOrder(TILE_KEYFRAMES)].slice(0, TILE_KEYFRAMES / 8).sort((a, b) => a - b);
  eighth.forEach((slot, i) => assert.equal(slot, 8 * i));
});

test('a map is cut into tiles; in a hurry each has fewer frusta', () => {
  const view = viewOf(along(TILE_KEYFRAMES + 100));
  assert.equal(view.setDetail(1, () => Infinity), TILE_KEYFRAMES + 100);
  assert.deepEqual(drawn(view).sort((a, b) => a - b), Array.from({ length: TILE_KEYFRAMES + 100 }, (_, i) => i));
  assert.equal(view.setDetail(0.25, () => Infinity), TILE_KEYFRAMES / 4 + 25);
  view.frusta.visible = false;
  assert.equal(view.setDetail(1, () => Infinity), 0);
});

test('a tile is bounded by its keyframes and as far as a frustum reaches', () => {
  const view = viewOf(along(TILE_KEYFRAMES + 1));
  const spheres: Sphere[] = [];
  view.setDetail(1, (sphere) => (spheres.push(sphere.clone()), 1));
  assert.equal(spheres.length, 2);
  assert.deepEqual(spheres[1].center.toArray(), [TILE_KEYFRAMES, 0, 0]);
  assert.ok(spheres[1].radius > 1 && spheres[1].radius < 3);
  assert.ok(spheres[0].radius > TILE_KEYFRAMES / 2 && spheres[0].radius < TILE_KEYFRAMES / 2 + 3);
});

test('only tiles that changed are handed over', () => {
  const store = along(3 * TILE_KEYFRAMES);
  const view = viewOf(store);
  assert.equal(view.sync(store), 0);
  put(store, TILE_KEYFRAMES + 3, -5);
  assert.equal(view.sync(store), 160 * TILE_KEYFRAMES);
  put(store, 3 * TILE_KEYFRAMES, 7);
  assert.equal(view.sync(store), 160);
  view.setDetail(1, () => Infinity);
  assert.ok(drawn(view).includes(-5) && !drawn(view).includes(TILE_KEYFRAMES + 3));
});

test('of a path only what changed is handed over, and all of it if it was not drawn before', () => {
  const view = viewOf(along(100));
  const show = () => view.path.setDetail(false, () => Infinity);
  assert.equal(show(), 96 * 99);
  assert.equal(show(), 0);
  const buffer = (view.path.lines.mesh.geometry.getAttribute('start') as InterleavedBufferAttribute).data;
  buffer.clearUpdateRanges();
  for (const index of [70, 20]) {
    put(view.store, index, index + 0.3);
    view.sync(view.store);
    assert.equal(show(), 2 * 96);
  }
  assert.deepEqual(buffer.updateRanges, [{ start: 19 * 24, count: 52 * 24 }]);
});

test('a path is drawn with the corners that can be told apart', () => {
  const view = viewOf(along(1000));
  const corners = () => view.path.lines.segments + 1;
  view.path.setDetail(false, () => 5000);
  assert.equal(corners(), 1000);
  view.path.setDetail(false, () => 1);
  assert.equal(corners(), 17);
});

test('tolerances are powers of two, never above what pixels allow', () => {
  assert.equal(pathTolerance(Infinity, true), 0);
  assert.equal(pathTolerance(41, false), 0);
  assert.equal(pathTolerance(4, false), 0.0625);
  assert.equal(pathTolerance(4, true), 0.25);
  assert.equal(pathTolerance(0.001, false), 256);
});

test('a simplified path keeps its ends and runs nowhere too far from where it was', () => {
  for (const count of [0, 1, 2, 64, 65, 66, 500]) {
    const path = Float32Array.from({ length: 3 * count }, (_, i) => (i % 3 === 0 ? i / 3 : Math.sin(i / 20)));
    const kept = simplify(path, count, 0.1);
    assert.deepEqual([...new Set(kept)].sort((a, b) => a - b), kept);
    assert.deepEqual([kept[0], kept.at(-1)], count > 0 ? [0, count - 1] : [undefined, undefined]);
    for (let j = 1; j < kept.length; j++) {
      for (let i = kept[j - 1]; i <= kept[j]; i++) {
        const t = (i - kept[j - 1]) / (kept[j] - kept[j - 1]);
        const y = path[3 * kept[j - 1] + 1] * (1 - t) + path[3 * kept[j] + 1] * t;
        assert.ok(Math.abs(y - path[3 * i + 1]) < 0.15, `${i}`);
      }
    }
    if (count === 500) assert.ok(kept.length < 250, `${kept.length}`);
  }
});

test('a path follows the order of time, however keyframes come', () => {
  const store = along(3);
  for (const [index, timeNs] of [[9, 5n], [8, 4n], [7, 9n]] as const) {
    store.slotsByTime();
    store.set(index, { timestampNs: timeNs, pose: { centre: [Number(timeNs), 0, 0], rotation: [0, 0, 0, 1] }, placed: true }, 0, 1);
  }
  const times = () => store.slotsByTime().map((slot) => store.records.get(store.indices[slot])!.timestampNs);
  assert.deepEqual(times(), [0n, 1n, 2n, 4n, 5n, 9n]);
  store.remove(1);
  put(store, 100, 3);
  assert.deepEqual(times(), [0n, 2n, 4n, 5n, 9n, 100n]);
});

test('keyframes that go leave no frustum behind', () => {
  const store = along(TILE_KEYFRAMES + 2);
  const view = viewOf(store);
  for (const index of [0, TILE_KEYFRAMES + 1, 5]) store.remove(index);
  view.sync(store);
  view.setDetail(1, () => Infinity);
  const left = Array.from({ length: TILE_KEYFRAMES + 1 }, (_, i) => i).filter((i) => i !== 0 && i !== 5);
  assert.deepEqual(drawn(view).sort((a, b) => a - b), left);
});

test('another store, of the past, replaces all', () => {
  const store = along(TILE_KEYFRAMES);
  const view = viewOf(store);
  view.sync(along(2));
  view.setDetail(1, () => Infinity);
  assert.deepEqual(drawn(view), [0, 1]);
  view.sync(store);
  assert.equal(view.setDetail(1, () => Infinity), TILE_KEYFRAMES);
});

test('a box is widened by some places and passes over what is no number', () => {
  const box = enclose(new Float32Array([0, 0, 0, 9, 1, 2, 3, 9, NaN, 1, 1, 9]), 4, 1, 3);
  assert.deepEqual([box.min.toArray(), box.max.toArray()], [[1, 1, 1], [1, 2, 3]]);
});
