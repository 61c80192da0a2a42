import { BLOCK_POINTS, POINT_FLOATS, PointBlock } from './point_block';
import { PagedIndex } from './paged_index';
import { Random } from './random';

/** The map points of one local map, in blocks. */
export class PointStore {
  readonly blocks: PointBlock[] = [];
  /** Of so many it was told how many keyframes see them. */
  observed = 0;
  private places = new PagedIndex();
  private lastMover: { number: number; moved: (index: number, slot: number) => void } | undefined;
  private readonly random = new Random();

  get count(): number {
    return this.places.size;
  }

  has(index: number): boolean {
    return this.places.get(index) !== undefined;
  }

  /**
   * Adds a point, or moves it; `age` is used where it is new. `observations`: how many keyframes see
   * it, 0: not told. Returns whether it was new.
   */
  set(index: number, x: number, y: number, z: number, age: number, generation: number, observations = 0): boolean {
    const place = this.places.get(index);
    const isNew = place === undefined;
    const at = isNew ? this.insert(index) : place;
    const block = this.blocks[Math.floor(at / BLOCK_POINTS)];
    const slot = at % BLOCK_POINTS;
    block.write(slot, x, y, z, isNew ? age : block.columns[slot * POINT_FLOATS + 3]);
    block.generations[slot] = generation;
    this.observed += Number(observations > 0) - Number(!isNew && block.observations[slot] > 0);
    block.observations[slot] = observations;
    return isNew;
  }

  remove(index: number): boolean {
    const place = this.places.get(index);
    if (place === undefined) return false;
    this.places.delete(index);
    const number = Math.floor(place / BLOCK_POINTS);
    if (this.blocks[number].observations[place % BLOCK_POINTS] > 0) this.observed--;
    this.blocks[number].remove(place % BLOCK_POINTS, this.mover(number));
    return true;
  }

  /** Removes what was not told since a generation began. */
  sweep(generation: number): void {
    for (const block of this.blocks) {
      for (let slot = block.count - 1; slot >= 0; slot--) {
        if (block.generations[slot] < generation) this.remove(block.indices[slot]);
      }
    }
  }

  position(index: number): [number, number, number] | undefined {
    const place = this.places.get(index);
    if (place === undefined) return undefined;
    const { columns } = this.blocks[Math.floor(place / BLOCK_POINTS)];
    const at = (place % BLOCK_POINTS) * POINT_FLOATS;
    return [columns[at], columns[at + 1], columns[at + 2]];
  }

  copy(): PointStore {
    const other = new PointStore();
    other.places = this.places.copy();
    other.observed = this.observed;
    for (const block of this.blocks) other.blocks.push(block.copy());
    return other;
  }

  private insert(index: number): number {
    if (!this.blocks.at(-1) || this.blocks.at(-1)!.full) this.blocks.push(new PointBlock());
    const number = this.blocks.length - 1;
    const slot = this.blocks[number].insert(index, this.random, this.mover(number));
    const place = number * BLOCK_POINTS + slot;
    this.places.set(index, place);
    return place;
  }

  private mover(number: number): (index: number, slot: number) => void {
    if (this.lastMover?.number !== number) {
      const moved = (index: number, slot: number) => this.places.set(index, number * BLOCK_POINTS + slot);
      this.lastMover = { number, moved };
    }
    return this.lastMover.moved;
  }
}
