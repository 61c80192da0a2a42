const SLOW_MS = 19;
const FAST_MS = 17.5;
const LEAST = 0.02;
/** So few points cost nothing; to leave some out would only flicker. */
const ALWAYS_DRAWN = 50_000;

/** How much of the points is drawn: all while nothing moves, as much as keeps up while it does. */
export class Detail {
  private moving = 1;
  private lastMs = 0;

  /** The fraction for a frame that begins now. */
  fraction(isMoving: boolean, points: number, nowMs: number): number {
    const frameMs = nowMs - this.lastMs;
    this.lastMs = nowMs;
    if (!isMoving) return 1;
    if (frameMs > SLOW_MS && frameMs < 2000) this.moving *= Math.max(0.5, SLOW_MS / frameMs);
    else if (frameMs < FAST_MS) this.moving *= 1.05;
    this.moving = Math.min(1, Math.max(LEAST, this.moving));
    return Math.min(1, Math.max(this.moving, ALWAYS_DRAWN / Math.max(points, 1)));
  }
}
