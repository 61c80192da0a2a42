// Where keypoints lie in a picture, and how two pictures are laid out. Pure.

/** Pixels of the camera's undistorted picture. */
export interface Spot {
  x: number;
  y: number;
}

export interface Size {
  width: number;
  height: number;
}

export interface Box extends Size {
  x: number;
  y: number;
}

/** The size of what the keypoints are of, by a picture that is `scale` times as small. */
export function fullSize(picture: Size, scale: number): Size {
  return { width: picture.width * scale, height: picture.height * scale };
}

/** Where a keypoint lies in a box that shows all of a picture: pixels are counted by their middles. */
export function placeIn(box: Box, full: Size, { x, y }: Spot): Spot {
  return { x: box.x + ((x + 0.5) / full.width) * box.width, y: box.y + ((y + 0.5) / full.height) * box.height };
}

/** What stands in for the size of a picture that is not there: all of its keypoints, and a little room. */
export function boundsOf(spots: readonly Spot[]): Size {
  const width = spots.reduce((most, { x }) => Math.max(most, x), 0);
  const height = spots.reduce((most, { y }) => Math.max(most, y), 0);
  return spots.length === 0 ? { width: 640, height: 480 } : { width: width + 16, height: height + 16 };
}

/** Puts a picture into a space, as large as it fits. */
export function fit(full: Size, space: Size): Size {
  const scale = Math.min(space.width / full.width, space.height / full.height);
  return { width: full.width * scale, height: full.height * scale };
}

/** Two pictures in one space, side by side or one below the other, whichever shows them larger. */
export interface Pair {
  first: Box;
  second: Box;
  size: Size;
}

export function arrange(first: Size, second: Size, space: Size, gap: number): Pair {
  const beside = lay(first, second, space, gap, true);
  const below = lay(first, second, space, gap, false);
  return beside.first.width * beside.first.height >= below.first.width * below.first.height ? beside : below;
}

function lay(first: Size, second: Size, space: Size, gap: number, isBeside: boolean): Pair {
  const half = isBeside
    ? { width: (space.width - gap) / 2, height: space.height }
    : { width: space.width, height: (space.height - gap) / 2 };
  const [a, b] = [fit(first, half), fit(second, half)];
  if (isBeside) {
    return {
      first: { x: 0, y: 0, ...a }, second: { x: a.width + gap, y: 0, ...b },
      size: { width: a.width + gap + b.width, height: Math.max(a.height, b.height) },
    };
  }
  return {
    first: { x: 0, y: 0, ...a }, second: { x: 0, y: a.height + gap, ...b },
    size: { width: Math.max(a.width, b.width), height: a.height + gap + b.height },
  };
}

/** At most so many of all, evenly. */
export function some<T>(all: readonly T[], most: number): T[] {
  if (all.length <= most) return [...all];
  return Array.from({ length: most }, (_, i) => all[Math.floor((i * all.length) / most)]);
}
