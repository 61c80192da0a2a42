import { POINT_FLOATS } from './point_block';
import type { PointStore } from './point_store';

/** The lowest and the highest of x, y and z. */
export interface Extent {
  low: [number, number, number];
  high: [number, number, number];
}

/** Points of each block that are looked at: slots are in random order, so that these stand for all. */
const MOST_SAMPLES = 4096;
const FEWEST_OF_A_BLOCK = 16;
/** This part of the points is shown; what is farther from the keyframes than all of these is left out. */
const PART = 0.95;
/** Nor is shown what is farther than so many times the usual distance, however much of it there is. */
const USUAL_TIMES = 6;

/**
 * Widens an extent of keyframes to the points around them, in the same frame. Points that are far
 * off for their kind (sky, wrong depths) don't count.
 */
export function withPoints(keyframes: Extent, points: PointStore): Extent {
  const samples = sample(points);
  const distances = samples.map((at) => distanceFrom(keyframes, at));
  const sorted = distances.filter(Number.isFinite).sort((a, b) => a - b);
  if (sorted.length === 0) return keyframes;
  const size = Math.hypot(...keyframes.high.map((value, k) => value - keyframes.low[k]));
  const reach = Math.min(quantile(sorted, PART), size + USUAL_TIMES * quantile(sorted, 0.5));
  const wide: Extent = { low: [...keyframes.low], high: [...keyframes.high] };
  samples.forEach((at, i) => {
    if (!(distances[i] <= reach)) return;
    for (let k = 0; k < 3; k++) {
      wide.low[k] = Math.min(wide.low[k], at[k]);
      wide.high[k] = Math.max(wide.high[k], at[k]);
    }
  });
  return wide;
}

function sample({ blocks, count }: PointStore): number[][] {
  const part = Math.min(1, MOST_SAMPLES / Math.max(count, 1));
  return blocks.flatMap((block) => {
    const taken = Math.min(block.count, Math.max(FEWEST_OF_A_BLOCK, Math.ceil(block.count * part)));
    return Array.from({ length: taken }, (_, i) => Array.from(block.columns.subarray(i * POINT_FLOATS, i * POINT_FLOATS + 3)));
  });
}

/** From the nearest place inside the extent. */
function distanceFrom({ low, high }: Extent, at: number[]): number {
  return Math.hypot(...at.map((value, k) => Math.max(low[k] - value, 0, value - high[k])));
}

function quantile(sorted: number[], part: number): number {
  return sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))];
}
