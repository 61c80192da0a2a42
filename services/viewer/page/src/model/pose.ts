import type { Rigid } from '@gen/corbslam/v1/geometry_pb';
import { type Quat, type Vec3, conjugate, normalised, rotate } from './vector';

/** Where a camera is in a frame: frame_from_camera. */
export interface Pose {
  centre: Vec3;
  rotation: Quat;
}

/** The inverse of camera_from_frame; undefined where the message is not a motion. */
export function poseOfCamera(cameraFromFrame: Rigid | undefined): Pose | undefined {
  const forward = poseOfRigid(cameraFromFrame);
  if (!forward) return undefined;
  const rotation = conjugate(forward.rotation);
  const [x, y, z] = rotate(rotation, forward.centre);
  return { centre: [0 - x, 0 - y, 0 - z], rotation };
}

/** frame_from_camera as it is. */
export function poseOfRigid(rigid: Rigid | undefined): Pose | undefined {
  if (rigid?.rotationWxyz.length !== 4 || rigid.translation.length !== 3) return undefined;
  const [w, x, y, z] = rigid.rotationWxyz;
  const centre: Vec3 = [rigid.translation[0], rigid.translation[1], rigid.translation[2]];
  if (![w, x, y, z, ...centre].every(Number.isFinite)) return undefined;
  return { centre, rotation: normalised([x, y, z, w]) };
}
