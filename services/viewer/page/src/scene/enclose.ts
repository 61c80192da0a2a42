import { Box3 } from 'three';

/** Widens a box to the places (x, y, z first of each `stride` floats) of some slots, `end` not included. */
export function enclose(columns: Float32Array, stride: number, start: number, end: number, box = new Box3()): Box3 {
  const { min, max } = box;
  for (let i = start; i < end; i++) {
    const [x, y, z] = [columns[i * stride], columns[i * stride + 1], columns[i * stride + 2]];
    if (x < min.x) min.x = x;
    if (y < min.y) min.y = y;
    if (z < min.z) min.z = z;
    if (x > max.x) max.x = x;
    if (y > max.y) max.y = y;
    if (z > max.z) max.z = z;
  }
  return box;
}
