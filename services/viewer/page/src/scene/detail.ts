/** What a frame may take. */
const GOAL_MS = 19;
/** A display of 50 pictures a second is fast; between the two nothing changes. */
const FAST_MS = 21;
const SLOW_MS = 25;
/** One such frame is no chance delay: its next one has a tenth. */
const VERY_SLOW_MS = 250;
const LEAST = 0.02;
/** Nobody knows yet how fast this machine draws: the first picture is not to wait for all of the map. */
const FIRST = 0.1;
/** So few cost a graphics processor nothing; to leave some out would only flicker. On fewer pixels, fewer do. */
const ALWAYS_DRAWN_POINTS = 50_000;
const ALWAYS_DRAWN_KEYFRAMES = 1_000;

/** With the fewest points drawn, a frame that takes longer has too many pixels. */
const TOO_MANY_PIXELS_MS = 60;
/** Of the screen's pixels along each side. */
const FEWER_PIXELS = 0.5;
/** So much of the points comes back before all pixels do, so that they don't come and go. */
const WITH_ALL_PIXELS = 0.5;

/** Which part of the map's points and keyframes is drawn, and of the pixels along each side. */
export interface Share {
  points: number;
  keyframes: number;
  pixels: number;
}

/** How much of the map is drawn: all while nothing moves, as much as keeps up while it does. */
export class Detail {
  private pixels = 1;

  constructor(private moving = FIRST) {}

  /** What a frame took, from its begin to when the browser asked for the next one. */
  took(frameMs: number): void {
    if (frameMs > SLOW_MS) this.moving *= Math.max(frameMs > VERY_SLOW_MS ? 0.1 : 0.5, GOAL_MS / frameMs);
    else if (frameMs < FAST_MS) this.moving *= 1.05;
    this.moving = Math.min(1, Math.max(LEAST, this.moving));
    if (this.moving === LEAST && frameMs > TOO_MANY_PIXELS_MS) this.pixels = FEWER_PIXELS;
    else if (this.moving >= WITH_ALL_PIXELS) this.pixels = 1;
  }

  /** The shares of a map of so many points and keyframes for a frame that begins now. */
  share(isMoving: boolean, points: number, keyframes: number): Share {
    if (!isMoving) return { points: 1, keyframes: 1, pixels: 1 };
    const area = this.pixels * this.pixels;
    return {
      points: atLeast(this.moving, ALWAYS_DRAWN_POINTS * area, points),
      keyframes: atLeast(this.moving, ALWAYS_DRAWN_KEYFRAMES * area, keyframes),
      pixels: this.pixels,
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

/** A path may run so far, in pixels, from where it was. */
const PATH_PX = 0.4;
const HURRIED_PATH_PX = 1.5;
/** Nearer than this, a path is drawn as it is. */
const FINE_UNITS = 0.01;

/**
 * How far, in units, a path may run from where it was: a power of two, so that a path is not made
 * anew for each step of the camera. 0: nowhere.
 */
export function pathTolerance(pixelsPerUnit: number, isHurried: boolean): number {
  const units = (isHurried ? HURRIED_PATH_PX : PATH_PX) / pixelsPerUnit;
  return units < FINE_UNITS ? 0 : 2 ** Math.floor(Math.log2(units));
}
