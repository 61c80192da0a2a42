import type { TrajectoryPose } from '@gen/corbslam/v1/resources_pb';
import { lastSegment } from '../model/ids';
import { poseOfRigid } from '../model/pose';
import type { Lines } from './lines';

/** A trajectory's poses by the local map that they belong to, as segments (x, y, z twice each). */
export function segmentsByLocalMap(poses: TrajectoryPose[]): Map<string, number[]> {
  const segments = new Map<string, number[]>();
  let before: { key: string; centre: number[] } | undefined;
  for (const told of poses) {
    const pose = poseOfRigid(told.frameFromCamera);
    if (!pose) continue;
    const localMap = lastSegment(told.localMap);
    const key = `${told.agent}|${localMap}`;
    if (!segments.has(localMap)) segments.set(localMap, []);
    if (before?.key === key && !told.afterGap) segments.get(localMap)!.push(...before.centre, ...pose.centre);
    before = { key, centre: pose.centre };
  }
  return segments;
}

export function showSegments(lines: Lines, segments: number[]): void {
  lines.array(segments.length / 6).set(segments);
  lines.commit(segments.length / 6);
}
