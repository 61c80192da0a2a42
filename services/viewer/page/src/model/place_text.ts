import type { Similarity } from '@gen/corbslam/v1/geometry_pb';
import { poseOfRigid } from './pose';
import { type Vec3, conjugate, rotate } from './vector';

/** Where a camera is in its island's frame (x to the right, y down, z ahead of the camera that began it), and where it looks. */
export interface Place {
  centre: Vec3;
  /** Degrees to the right of the island's z axis, as seen from above. */
  headingDeg: number;
  /** Degrees above the horizon of the camera that began the island. */
  pitchDeg: number;
}

/** Undefined: the message is no motion. */
export function placeOf(cameraFromIsland: Similarity | undefined): Place | undefined {
  if (!cameraFromIsland) return undefined;
  const { rotationWxyz, translation, scale = 1 } = cameraFromIsland;
  if (!(scale > 0)) return undefined;
  const pose = poseOfRigid({ rotationWxyz, translation } as Parameters<typeof poseOfRigid>[0]);
  if (!pose) return undefined;
  const back = conjugate(pose.rotation);
  const turned = rotate(back, pose.centre);
  const [x, y, z] = rotate(back, [0, 0, 1]);
  const degrees = (radians: number) => (180 * radians) / Math.PI;
  return {
    centre: turned.map((value) => 0 - value / scale) as Vec3,
    headingDeg: degrees(Math.atan2(x, z)), pitchDeg: degrees(Math.asin(Math.max(-1, Math.min(1, -y)))),
  };
}

export function positionText({ centre }: Place): string {
  return `${centre.map((value) => number(value, 2)).join(', ')} m`;
}

export function headingText({ headingDeg, pitchDeg }: Place): string {
  const side = Math.abs(headingDeg) < 0.05 ? 'ahead' : `${Math.abs(headingDeg).toFixed(1)}° ${headingDeg > 0 ? 'right' : 'left'}`;
  const tilt = Math.abs(pitchDeg) < 0.05 ? 'level' : `${Math.abs(pitchDeg).toFixed(1)}° ${pitchDeg > 0 ? 'up' : 'down'}`;
  return `${side}, ${tilt}`;
}

/** Between two places of the picture, y up; undefined island: of the ground alone nothing is known. */
export function distanceText(a: Vec3, b: Vec3): string {
  const [dx, dy, dz] = [0, 1, 2].map((k) => b[k] - a[k]);
  const all = metres(Math.hypot(dx, dy, dz));
  return `${all}: ${metres(Math.hypot(dx, dz))} along the ground, ${metres(Math.abs(dy))} of height`;
}

function metres(value: number): string {
  return `${value.toFixed(value < 100 ? 2 : 1)} m`;
}

function number(value: number, digits: number): string {
  const words = Math.abs(value).toFixed(digits);
  return value < 0 && Number(words) !== 0 ? `−${words}` : words;
}
