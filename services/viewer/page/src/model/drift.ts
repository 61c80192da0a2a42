import type { Similarity } from '@gen/corbslam/v1/geometry_pb';
import type { Keyframe } from '@gen/corbslam/v1/resources_pb';
import { poseOfCamera, poseOfRigid } from './pose';
import type { KeyframeStore } from './keyframe_store';
import { type Vec3, conjugate, rotate } from './vector';
import { count } from './texts';

/** How far fusion has moved a robot's newest keyframe against what the robot itself found. */
export interface Drift {
  distanceM: number;
  /** The way along the keyframes between the first and it; 0: not known. */
  wayM: number;
}

/**
 * The distance between where the newest keyframe is in its island and where the local map would
 * have put it, laid on the island at its first keyframe. Undefined where the two are not of one
 * island, or a pose is none.
 */
export function driftBetween(first: Keyframe, newest: Keyframe): number | undefined {
  if (first.island !== newest.island) return undefined;
  const seen = poseOfRigid(first.cameraFromLocal);
  const local = poseOfCamera(newest.cameraFromLocal)?.centre;
  const island = centreIn(newest.cameraFromIsland);
  if (!seen || !local || !island) return undefined;
  const turned = rotate(seen.rotation, local);
  const inFirst: Vec3 = [0, 1, 2].map((i) => turned[i] + seen.centre[i]) as Vec3;
  const expected = fromCamera(first.cameraFromIsland, inFirst);
  return expected && Math.hypot(...[0, 1, 2].map((i) => island[i] - expected[i]));
}

/** The camera's centre. */
function centreIn(cameraFromIsland: Similarity | undefined): Vec3 | undefined {
  return fromCamera(cameraFromIsland, [0, 0, 0]);
}

/** A point in the camera's frame, in the island's: x_camera = scale * rotation * x_island + translation. */
function fromCamera(cameraFromIsland: Similarity | undefined, point: Vec3): Vec3 | undefined {
  if (!cameraFromIsland) return undefined;
  const { rotationWxyz, translation, scale = 1 } = cameraFromIsland;
  const pose = poseOfRigid({ rotationWxyz, translation } as Parameters<typeof poseOfRigid>[0]);
  if (!pose || !(scale > 0)) return undefined;
  const [x, y, z] = [0, 1, 2].map((i) => (point[i] - pose.centre[i]) / scale);
  return rotate(conjugate(pose.rotation), [x, y, z]);
}

/** The way along all keyframes of a local map, in its island. */
export function wayAlong(keyframes: KeyframeStore): number {
  const slots = keyframes.slotsByTime();
  const { centres } = keyframes;
  let way = 0;
  for (let i = 1; i < slots.length; i++) {
    const [a, b] = [4 * slots[i - 1], 4 * slots[i]];
    way += Math.hypot(centres[b] - centres[a], centres[b + 1] - centres[a + 1], centres[b + 2] - centres[a + 2]);
  }
  return way;
}

export function driftText(drift: Drift | undefined): string {
  if (!drift) return 'not yet';
  const { distanceM, wayM } = drift;
  const distance = `${distanceM.toFixed(distanceM < 10 ? 2 : 1)} m`;
  return wayM > 0 ? `${distance} in ${count(Math.round(wayM))} m` : distance;
}
