import { type Box3, Vector3 } from 'three';

/**
 * How far from a box's middle a camera must be that sees all its corners. It looks against `away`, a
 * unit vector; `aside` and `up` are the tangents of half of its angles of view.
 */
export function distanceToSee(box: Box3, away: Vector3, worldUp: Vector3, aside: number, up: number): number {
  const right = new Vector3().crossVectors(worldUp, away);
  if (right.lengthSq() < 1e-12) right.set(1, 0, 0);
  right.normalize();
  const above = new Vector3().crossVectors(away, right);
  const half = box.max.clone().sub(box.min).multiplyScalar(0.5);
  let distance = 0;
  for (let i = 0; i < 8; i++) {
    const corner = half.clone().multiply(new Vector3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
    const beyond = Math.max(Math.abs(corner.dot(right)) / aside, Math.abs(corner.dot(above)) / up);
    distance = Math.max(distance, corner.dot(away) + beyond);
  }
  return distance;
}
