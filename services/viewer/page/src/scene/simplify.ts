/** A path is cut into pieces of so many steps, whose ends stay: the cost of a long straight stays small. */
const PIECE = 64;

/**
 * The points of a path (x, y, z each) of which it may be drawn so that it nowhere runs farther than
 * `tolerance` from where it was (Douglas and Peucker), in order; the first and the last are among them.
 */
export function simplify(path: Float32Array, count: number, tolerance: number): number[] {
  const kept: number[] = [];
  for (let start = 0; start < count; start += PIECE) {
    kept.push(start);
    keepBetween(path, start, Math.min(start + PIECE, count - 1), tolerance * tolerance, kept);
  }
  if (count > 1 && kept.at(-1) !== count - 1) kept.push(count - 1);
  return kept;
}

function keepBetween(path: Float32Array, start: number, end: number, tolerance2: number, kept: number[]): void {
  let [farthest, most] = [-1, tolerance2];
  for (let i = start + 1; i < end; i++) {
    const distance2 = toSegment2(path, i, start, end);
    if (distance2 > most) [farthest, most] = [i, distance2];
  }
  if (farthest < 0) return;
  keepBetween(path, start, farthest, tolerance2, kept);
  kept.push(farthest);
  keepBetween(path, farthest, end, tolerance2, kept);
}

/** The square of the distance of a point from the segment between two others. */
function toSegment2(path: Float32Array, point: number, start: number, end: number): number {
  const [a, b, p] = [3 * start, 3 * end, 3 * point];
  let [along, length2, away2] = [0, 0, 0];
  for (let k = 0; k < 3; k++) {
    const way = path[b + k] - path[a + k];
    along += way * (path[p + k] - path[a + k]);
    length2 += way * way;
  }
  const t = length2 > 0 ? Math.min(1, Math.max(0, along / length2)) : 0;
  for (let k = 0; k < 3; k++) away2 += (path[p + k] - path[a + k] - t * (path[b + k] - path[a + k])) ** 2;
  return away2;
}
