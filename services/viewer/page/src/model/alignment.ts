import type { Pose } from './pose';
import { type Quat, type Vec3, conjugate, dot4, multiply, normalised, rotate } from './vector';

/** x_target = scale * rotation * x_source + translation. */
export interface Alignment {
  scale: number;
  rotation: Quat;
  translation: Vec3;
}

/**
 * The similarity that takes poses to others of the same cameras. The rotation is the mean of the
 * cameras' own, because a path along a line would leave one angle open.
 */
export function alignPoses(source: Pose[], target: Pose[]): Alignment | undefined {
  if (source.length === 0 || source.length !== target.length) return undefined;
  const rotation = meanRotation(source, target);
  const sourceMean = mean(source);
  const targetMean = mean(target);
  const spread = spreadAround(source, sourceMean);
  const scale = spread > 1e-9 ? spreadAround(target, targetMean) / spread : 1;
  const turned = rotate(rotation, sourceMean);
  return {
    scale: scale > 1e-6 ? scale : 1,
    rotation,
    translation: [
      targetMean[0] - scale * turned[0],
      targetMean[1] - scale * turned[1],
      targetMean[2] - scale * turned[2],
    ],
  };
}

function meanRotation(source: Pose[], target: Pose[]): Quat {
  const sum: Quat = [0, 0, 0, 0];
  for (let i = 0; i < source.length; i++) {
    const turn = multiply(target[i].rotation, conjugate(source[i].rotation));
    const sign = dot4(sum, turn) < 0 ? -1 : 1;
    for (let k = 0; k < 4; k++) sum[k] += sign * turn[k];
  }
  return normalised(sum);
}

function mean(poses: Pose[]): Vec3 {
  const sum: Vec3 = [0, 0, 0];
  for (const { centre } of poses) for (let k = 0; k < 3; k++) sum[k] += centre[k] / poses.length;
  return sum;
}

function spreadAround(poses: Pose[], middle: Vec3): number {
  let sum = 0;
  for (const { centre } of poses) for (let k = 0; k < 3; k++) sum += (centre[k] - middle[k]) ** 2;
  return Math.sqrt(sum / poses.length);
}
