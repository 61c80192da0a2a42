import { type DrivenPath, firstFrame } from './driven';
import type { KeyframeStore } from './keyframe_store';
import { isGap, isNear, usualStep } from './step';

/** The way along a local map, in its island's frame. */
export interface Way {
  /** x, y, z for each place. */
  points: Float32Array;
  count: number;
  /** Where a piece begins that is not connected with the one before, ascending; the first is 0. */
  begins: number[];
  /** The keyframes alone do not say all of it: somewhere between them a straight line would be wrong. */
  hasGaps: boolean;
}

/**
 * Through the keyframes in time. Where a straight line would not be where the robot went, it follows
 * the frames, where those are known; else there is a gap.
 */
export function wayOf(store: KeyframeStore, driven?: DrivenPath): Way {
  const writer = new WayWriter(store, driven);
  const slots = store.slotsByTime();
  slots.forEach((slot, i) => writer.keyframe(slot, slots[i - 1]));
  return writer.end(slots.at(-1));
}

class WayWriter {
  private readonly usual: number;
  private points: Float32Array;
  private count = 0;
  private readonly begins: number[] = [0];
  private hasGaps = false;

  constructor(private readonly store: KeyframeStore, private readonly driven: DrivenPath | undefined) {
    this.usual = usualStep(store);
    this.points = new Float32Array(3 * Math.max(1, store.count));
  }

  keyframe(slot: number, before: number | undefined): void {
    if (before === undefined) this.head(slot);
    else if (isGap(this.store, before, slot, this.usual)) this.between(before, slot);
    this.add(this.store.centres, 4 * slot);
  }

  end(last: number | undefined): Way {
    if (last !== undefined && this.driven) {
      const first = firstFrame(this.driven, this.timeOf(last), true);
      const end = this.driven.timesNs.length;
      // Frames behind a robot's newest keyframe are near it; of a session that was thinned they are far.
      if (first < end && !this.isNearTo(4 * last, end - 1)) this.frames(first, end);
    }
    return { points: this.points, count: this.count, begins: this.begins, hasGaps: this.hasGaps };
  }

  /** Frames before the first keyframe that is left. */
  private head(slot: number): void {
    if (!this.driven) return;
    const end = firstFrame(this.driven, this.timeOf(slot), false);
    if (end === 0 || this.isNearTo(4 * slot, 0)) return;
    this.frames(0, end);
    this.joinTo(slot, end);
  }

  private between(before: number, slot: number): void {
    this.hasGaps = true;
    if (!this.driven) return this.break();
    const first = firstFrame(this.driven, this.timeOf(before), true);
    const end = firstFrame(this.driven, this.timeOf(slot), false);
    if (end <= first) return this.break();
    this.frames(first, end);
    this.joinTo(slot, end);
  }

  /** `end`: the frame that is the keyframe's own, where there is one. */
  private joinTo(slot: number, end: number): void {
    const { driven } = this;
    // The keyframe's own frame says whether it is connected with the one before.
    const isOwn = driven!.timesNs[end] === this.timeOf(slot);
    if (isOwn ? driven!.afterGap[end] : !this.isNearTo(4 * slot, end - 1)) this.break();
  }

  private frames(first: number, end: number): void {
    const { places, afterGap } = this.driven!;
    for (let i = first; i < end; i++) {
      if (this.count > 0 && afterGap[i]) this.break();
      this.add(places, 3 * i);
    }
  }

  private break(): void {
    if (this.begins.at(-1) !== this.count) this.begins.push(this.count);
  }

  private add(from: ArrayLike<number>, at: number): void {
    if (3 * this.count + 3 > this.points.length) {
      const { points } = this;
      (this.points = new Float32Array(2 * points.length + 3)).set(points);
    }
    for (let k = 0; k < 3; k++) this.points[3 * this.count + k] = from[at + k];
    this.count++;
  }

  private timeOf(slot: number): bigint {
    return this.store.records.get(this.store.indices[slot])!.timestampNs;
  }

  private isNearTo(keyframe: number, frame: number): boolean {
    const { places } = this.driven!;
    return isNear(Math.hypot(...[0, 1, 2].map((k) => places[3 * frame + k] - this.store.centres[keyframe + k])), this.usual);
  }
}
