/** Keyframes of one tile: few enough to be a place, enough for few draw calls. A power of two. */
export const TILE_KEYFRAMES = 512;

const ALL = Array.from({ length: TILE_KEYFRAMES }, (_, i) => reversed(i));

/**
 * The first `count` slots of a tile, ordered so that each prefix is spread evenly over them: slots
 * follow the robot's way, so that a prefix is the same way with longer steps.
 */
export function spreadOrder(count: number): readonly number[] {
  return count === TILE_KEYFRAMES ? ALL : ALL.filter((slot) => slot < count);
}

/** The bits of a slot's number from the last to the first. */
function reversed(slot: number): number {
  let result = 0;
  for (let bit = 1; bit < TILE_KEYFRAMES; bit *= 2) result = 2 * result + (slot & bit ? 1 : 0);
  return result;
}
