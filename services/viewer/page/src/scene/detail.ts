const SLOW_MS = 19;
const FAST_MS = 17.5;
const LEAST = 0.02;
/** So few points cost nothing; to leave some out would only flicker. */
const ALWAYS_DRAWN_POINTS = 50_000;
/** A frustum is 16 vertices and eight lines: so many frusta are drawn in every hurry. */
const ALWAYS_DRAWN_KEYFRAMES = 1_000;

/** Which part of the map's points and keyframes is drawn. */
export interface Share {
  points: number;
  keyframes: number;
}

/** How much of the map is drawn: all while nothing moves, as much as keeps up while it does. */
export class Detail {
  private moving = 1;
  private lastMs = 0;

  /** The shares for a frame that begins now, of a map of so many points and keyframes. */
  share(isMoving: boolean, points: number, keyframes: number, nowMs: number): Share {
    const frameMs = nowMs - this.lastMs;
    this.lastMs = nowMs;
    if (!isMoving) return { points: 1, keyframes: 1 };
    if (frameMs > SLOW_MS && frameMs < 2000) this.moving *= Math.max(0.5, SLOW_MS / frameMs);
    else if (frameMs < FAST_MS) this.moving *= 1.05;
    this.moving = Math.min(1, Math.max(LEAST, this.moving));
    return {
      points: atLeast(this.moving, ALWAYS_DRAWN_POINTS, points),
      keyframes: atLeast(this.moving, ALWAYS_DRAWN_KEYFRAMES, keyframes),
    };
  }
}

function atLeast(share: number, always: number, count: number): number {
  return Math.min(1, Math.max(share, always / Math.max(count, 1)));
}

/** Of `count` items on a disc of a radius in pixels: how many are worth drawing, of a share of them. */
export function worthDrawing(count: number, share: number, radiusPx: number, perPixel: number, fewest: number): number {
  const enough = fewest + perPixel * Math.PI * radiusPx * radiusPx;
  return Math.ceil(Math.min(count, enough) * share);
}
