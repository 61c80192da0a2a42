import { Group, type RawShaderMaterial, type Sphere } from 'three';
import type { DrivenPath } from '../model/driven';
import type { KeyframeStore } from '../model/keyframe_store';
import { usualStep } from '../model/step';
import { KeyframeTile } from './keyframe_tile';
import { PathView } from './path_view';
import { TILE_KEYFRAMES } from './tile_order';

/** The keyframes of one local map as frusta, a draw for each tile of them, and their path in another. */
export class KeyframesView {
  readonly frusta = new Group();
  readonly path: PathView;
  private readonly tiles: KeyframeTile[] = [];
  private shownEdits = -1;
  private shownCount = 0;
  private shownDriven: DrivenPath | undefined;

  constructor(public store: KeyframeStore, readonly material: RawShaderMaterial, pathMaterial: RawShaderMaterial) {
    this.frusta.matrixAutoUpdate = false;
    this.path = new PathView(pathMaterial);
  }

  /** Takes over what changed; `driven`: where all frames were. Returns the bytes that go to the GPU. */
  sync(store: KeyframeStore, driven?: DrivenPath): number {
    const isSame = store === this.store && store.edits === this.shownEdits;
    if (!isSame || driven !== this.shownDriven) this.path.sync(store, driven);
    this.shownDriven = driven;
    if (isSame) return 0;
    const bytes = this.syncTiles(store, this.changedTiles(store));
    this.material.uniforms.size.value = frustumSize(store);
    this.store = store;
    this.shownEdits = store.edits;
    this.shownCount = store.count;
    return bytes;
  }

  /** Chooses which frusta are drawn. Returns how many. */
  setDetail(fraction: number, pixelsPerUnit: (sphere: Sphere) => number): number {
    if (!this.frusta.visible) return 0;
    const size: number = this.material.uniforms.size.value;
    return this.tiles.reduce((sum, tile) => sum + tile.setDetail(fraction, size, pixelsPerUnit), 0);
  }

  dispose(): void {
    for (const tile of this.tiles.splice(0)) tile.dispose();
    this.material.dispose();
    this.path.lines.dispose();
  }

  /** The tiles of which a keyframe moved, came or went; all of another store. */
  private changedTiles(store: KeyframeStore): Set<number> {
    const changed = new Set<number>();
    const spans = store.dirty.take(store.count);
    const isOther = store !== this.store || this.shownEdits < 0;
    if (isOther) spans.splice(0, spans.length, { start: 0, end: store.count });
    else if (store.count !== this.shownCount) spans.push({ start: Math.min(store.count, this.shownCount), end: store.count });
    for (const { start, end } of spans) {
      for (let tile = tileOf(start); tile <= tileOf(end - 1); tile++) changed.add(tile);
    }
    return changed;
  }

  private syncTiles(store: KeyframeStore, changed: Set<number>): number {
    const tiles = Math.ceil(store.count / TILE_KEYFRAMES);
    for (const tile of this.tiles.splice(tiles)) tile.dispose();
    while (this.tiles.length < tiles) {
      this.tiles.push(new KeyframeTile(this.material));
      this.frusta.add(this.tiles.at(-1)!.object);
    }
    let bytes = 0;
    for (const tile of changed) {
      const first = tile * TILE_KEYFRAMES;
      const count = Math.min(TILE_KEYFRAMES, store.count - first);
      if (count > 0) bytes += this.tiles[tile].write(store, first, count);
    }
    return bytes;
  }
}

/** Of the usual step between keyframes that are left: frusta of this size don't run into each other. */
const PART_OF_STEP = 0.6;
/** Where most keyframes of a session went, those that are left are far apart; they are drawn no larger for that. */
const MOST_STEPS = 2.5;

export function frustumSize(store: KeyframeStore): number {
  const slots = store.slotsByTime().slice(-200);
  const steps: number[] = [];
  for (let i = 1; i < slots.length; i++) {
    const [a, b] = [slots[i - 1] * 4, slots[i] * 4];
    const c = store.centres;
    steps.push(Math.hypot(c[a] - c[b], c[a + 1] - c[b + 1], c[a + 2] - c[b + 2]));
  }
  steps.sort((a, b) => a - b);
  const left = steps[steps.length >> 1] || 1;
  return PART_OF_STEP * Math.min(left, MOST_STEPS * usualStep(store) || left);
}

function tileOf(slot: number): number {
  return Math.floor(slot / TILE_KEYFRAMES);
}
