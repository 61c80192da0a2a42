import { DirtyPages } from './dirty_pages';
import type { Random } from './random';

const FIRST_CAPACITY = 1024;
export const BLOCK_POINTS = 16384;
/** x, y, z and the order of arrival. */
export const POINT_FLOATS = 4;

/** Told when a point moves to another slot. */
export type Moved = (index: number, slot: number) => void;

/**
 * Up to BLOCK_POINTS map points of one local map. Slots are in random order at all times, so that
 * the first n of them are a uniform subsample; points that came together share a block, so that a
 * block is a place, too.
 */
export class PointBlock {
  columns = new Float32Array(FIRST_CAPACITY * POINT_FLOATS);
  indices = new Uint32Array(FIRST_CAPACITY);
  generations = new Uint32Array(FIRST_CAPACITY);
  /** How many keyframes see each, up to 255; 0: that was not told. */
  observations = new Uint8Array(FIRST_CAPACITY);
  count = 0;
  readonly dirty = new DirtyPages();
  /** Grows with each change of a position, so that bounds can be kept. */
  edits = 0;

  get full(): boolean {
    return this.count === BLOCK_POINTS;
  }

  /** Inserts at a random slot; who was there goes to the end (inside-out shuffle). */
  insert(index: number, random: Random, moved: Moved): number {
    if (this.count === this.indices.length) this.grow();
    const slot = random.below(this.count + 1);
    if (slot !== this.count) this.move(slot, this.count, moved);
    this.count++;
    this.indices[slot] = index;
    return slot;
  }

  write(slot: number, x: number, y: number, z: number, age: number): void {
    const at = slot * POINT_FLOATS;
    this.columns[at] = x;
    this.columns[at + 1] = y;
    this.columns[at + 2] = z;
    this.columns[at + 3] = age;
    this.touch(slot);
  }

  remove(slot: number, moved: Moved): void {
    this.count--;
    if (slot !== this.count) this.move(this.count, slot, moved);
    this.edits++;
  }

  private move(from: number, to: number, moved: Moved): void {
    for (let k = 0; k < POINT_FLOATS; k++) this.columns[to * POINT_FLOATS + k] = this.columns[from * POINT_FLOATS + k];
    this.indices[to] = this.indices[from];
    this.generations[to] = this.generations[from];
    this.observations[to] = this.observations[from];
    this.touch(to);
    moved(this.indices[to], to);
  }

  private touch(slot: number): void {
    this.dirty.mark(slot);
    this.edits++;
  }

  private grow(): void {
    this.columns = grown(this.columns, new Float32Array(this.columns.length * 2));
    this.indices = grown(this.indices, new Uint32Array(this.indices.length * 2));
    this.generations = grown(this.generations, new Uint32Array(this.generations.length * 2));
    this.observations = grown(this.observations, new Uint8Array(this.observations.length * 2));
  }

  copy(): PointBlock {
    const other = new PointBlock();
    other.columns = this.columns.slice();
    other.indices = this.indices.slice();
    other.generations = this.generations.slice();
    other.observations = this.observations.slice();
    other.count = this.count;
    return other;
  }
}

function grown<T extends Float32Array | Uint32Array | Uint8Array>(from: T, to: T): T {
  to.set(from);
  return to;
}
