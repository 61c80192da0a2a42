import type { TrajectoryPose } from '@gen/corbslam/v1/resources_pb';
import { lastSegment } from './ids';
import { poseOfRigid } from './pose';

/** Where the frames of one local map were, in the frame of its island; in time. */
export interface DrivenPath {
  island: string;
  agent: string;
  timesNs: bigint[];
  /** x, y, z for each. */
  places: number[];
  /** For each: not connected with the one before. */
  afterGap: boolean[];
}

/** A trajectory of all robots, by what its frames belong to. */
export interface Driven {
  localMaps: Map<string, DrivenPath>;
  /** Runs of robots that only localised, which are in no local map. */
  runs: DrivenPath[];
}

export function drivenPaths(poses: readonly TrajectoryPose[]): Driven {
  const paths = new Map<string, { id: string; path: DrivenPath }>();
  for (const told of poses) {
    const pose = poseOfRigid(told.frameFromCamera);
    if (!pose) continue;
    const [id, island] = [lastSegment(told.localMap), lastSegment(told.island)];
    const key = [id || `${told.agent} ${told.run}`, island].join();
    let known = paths.get(key);
    if (!known) {
      known = { id, path: { island, agent: lastSegment(told.agent), timesNs: [], places: [], afterGap: [] } };
      paths.set(key, known);
    }
    known.path.afterGap.push(told.afterGap || known.path.timesNs.length === 0);
    known.path.timesNs.push(told.timestampNs);
    known.path.places.push(...pose.centre);
  }
  const all = [...paths.values()];
  return {
    localMaps: new Map(all.filter(({ id }) => id !== '').map(({ id, path }) => [id, path])),
    runs: all.filter(({ id }) => id === '').map(({ path }) => path),
  };
}

/** The number of the first frame behind a time, or of the first one at it or behind. */
export function firstFrame({ timesNs }: DrivenPath, timeNs: bigint, isBehind: boolean): number {
  let [low, high] = [0, timesNs.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (timesNs[middle] < timeNs || (isBehind && timesNs[middle] === timeNs)) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** The path as segments (x, y, z twice each); nothing over gaps. */
export function segmentsOf({ places, afterGap }: DrivenPath): number[] {
  const segments: number[] = [];
  for (let i = 1; i < afterGap.length; i++) {
    if (!afterGap[i]) segments.push(...places.slice(3 * i - 3, 3 * i + 3));
  }
  return segments;
}
