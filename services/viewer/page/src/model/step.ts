import type { KeyframeStore } from './keyframe_store';

/** Steps that are looked at to say how far a robot usually goes. */
const MOST_SAMPLES = 256;
/** A robot that turns on the spot makes many keyframes there: so large a part of its steps may be short. */
const PART = 0.75;
/** Times the usual step: nearer keyframes are joined however the robot turned between them... */
const NEAR = 4;
/** ... and farther ones never. */
const FAR = 12;
const MOST_TURN = 2.8;

/**
 * How far a robot usually went from one keyframe to the next that it made, in the island's unit; 0:
 * not known. Keyframes that went since, so that few are left of a closed session, leave it as it
 * was: their numbers are missing, and a step over them is shared out.
 */
export function usualStep(store: KeyframeStore): number {
  const slots = store.slotsByTime();
  const each = Math.max(1, Math.floor(slots.length / MOST_SAMPLES));
  const steps: number[] = [];
  for (let i = 1; i < slots.length; i += each) {
    const numbers = Math.abs(store.indices[slots[i]] - store.indices[slots[i - 1]]);
    if (numbers > 0) steps.push(lengthBetween(store, slots[i - 1], slots[i]) / numbers);
  }
  return steps.sort((a, b) => a - b)[Math.floor(PART * steps.length)] ?? 0;
}

/**
 * Whether a straight line between two keyframes that follow each other would run where the robot
 * may not have been: they are far apart, or far enough for the corner that lies between them.
 */
export function isGap(store: KeyframeStore, from: number, to: number, usual: number): boolean {
  const length = lengthBetween(store, from, to);
  if (usual <= 0 || length <= NEAR * usual) return false;
  if (length > FAR * usual) return true;
  return (length / 2) * Math.tan(Math.min(turnBetween(store, from, to), MOST_TURN) / 2) > usual;
}

/** Whether places so far apart may be joined without asking how the robot turned. */
export function isNear(length: number, usual: number): boolean {
  return usual <= 0 || length <= NEAR * usual;
}

function lengthBetween({ centres }: KeyframeStore, from: number, to: number): number {
  const [a, b] = [4 * from, 4 * to];
  return Math.hypot(centres[b] - centres[a], centres[b + 1] - centres[a + 1], centres[b + 2] - centres[a + 2]);
}

function turnBetween({ rotations }: KeyframeStore, from: number, to: number): number {
  let dot = 0;
  for (let k = 0; k < 4; k++) dot += rotations[4 * from + k] * rotations[4 * to + k];
  return 2 * Math.acos(Math.min(1, Math.abs(dot)));
}
