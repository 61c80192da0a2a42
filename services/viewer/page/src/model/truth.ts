import { type Alignment, alignPoses } from './alignment';
import type { MapModel } from './map_model';
import type { Pose } from './pose';
import { type Vec3, rotate } from './vector';

/** Where a camera really was, in a frame of its own. */
export interface TruePose extends Pose {
  timeS: number;
}

const CLOSE_S = 0.02;
const DASHES = 120;

/** Reads rows "time tx ty tz qx qy qz qw", sorted by time. */
export function parseTruth(text: string): TruePose[] {
  const poses: TruePose[] = [];
  for (const line of text.split('\n')) {
    const [timeS, x, y, z, qx, qy, qz, qw, ...more] = line.trim().split(/\s+/).map(Number);
    if (more.length > 0 || ![timeS, x, y, z, qx, qy, qz, qw].every(Number.isFinite)) continue;
    poses.push({ timeS, centre: [x, y, z], rotation: [qx, qy, qz, qw] });
  }
  return poses.sort((a, b) => a.timeS - b.timeS);
}

/** Where a map says that a camera was. */
export interface TimedPose {
  timestampNs: bigint;
  pose: Pose;
}

/** The keyframes of the reference island: the map has them, so nothing has to be asked for. */
export function referenceKeyframes(model: MapModel): TimedPose[] {
  const members = model.islands().get(model.globalIsland ?? '') ?? [];
  return members.flatMap(({ keyframes }) =>
    [...keyframes.records].map(([index, { timestampNs }]) => ({ timestampNs, pose: keyframes.pose(index)! })));
}

/** island_from_truth by the poses that have a true one of their time; undefined: there are too few. */
export function alignTruth(truth: TruePose[], told: TimedPose[]): Alignment | undefined {
  const source: Pose[] = [];
  const target: Pose[] = [];
  for (const { timestampNs, pose } of told) {
    const near = nearest(truth, Number(timestampNs) / 1e9);
    if (!near) continue;
    source.push(near);
    target.push(pose);
  }
  return source.length < 3 ? undefined : alignPoses(source, target);
}

/** How the truth lies on what was told. */
export interface TruthFit {
  /** Keyframes whose time it has. */
  common: number;
  /** Of their centres, in the island's unit. */
  rms: number;
}

export function truthFit(truth: TruePose[], told: TimedPose[], alignment: Alignment): TruthFit {
  let [common, sum] = [0, 0];
  for (const { timestampNs, pose } of told) {
    const near = nearest(truth, Number(timestampNs) / 1e9);
    if (!near) continue;
    const [x, y, z] = placed(near.centre, alignment);
    sum += (x - pose.centre[0]) ** 2 + (y - pose.centre[1]) ** 2 + (z - pose.centre[2]) ** 2;
    common++;
  }
  return { common, rms: common > 0 ? Math.sqrt(sum / common) : 0 };
}

function placed(centre: Vec3, { scale, rotation, translation }: Alignment): Vec3 {
  return rotate(rotation, centre).map((value, k) => scale * value + translation[k]) as Vec3;
}

/** Steps of time that are so much longer than most are gaps. */
const GAP = 10;

/** A dashed path in the island's frame, as segments (x, y, z twice each); nothing over gaps of time. */
export function dashes(truth: TruePose[], alignment: Alignment): number[] {
  const path = truth.map(({ centre }) => placed(centre, alignment));
  const steps = truth.slice(1).map(({ timeS }, i) => timeS - truth[i].timeS);
  const longest = GAP * ([...steps].sort((a, b) => a - b)[steps.length >> 1] ?? 0);
  const lengths = path.slice(1).map((to, i) => Math.hypot(...to.map((value, k) => value - path[i][k])));
  const dash = lengths.reduce((sum, length) => sum + length, 0) / (2 * DASHES);
  const segments: number[] = [];
  let travelled = 0;
  lengths.forEach((length, i) => {
    // The middle of a step decides: steps are short beside a dash, or few.
    const isGap = longest > 0 && steps[i] > longest;
    const isOn = dash === 0 || Math.floor((travelled + length / 2) / dash) % 2 === 0;
    if (isOn && !isGap) segments.push(...path[i], ...path[i + 1]);
    travelled += length;
  });
  return segments;
}

/** The same of x, y and z of one pose after the other that lie in the island's frame already. */
export function dashesOfPath(places: number[]): number[] {
  const rotation: Pose['rotation'] = [0, 0, 0, 1];
  const poses = Array.from({ length: Math.floor(places.length / 3) }, (_, timeS): TruePose =>
    ({ timeS, centre: places.slice(3 * timeS, 3 * timeS + 3) as Vec3, rotation }));
  return dashes(poses, { scale: 1, rotation, translation: [0, 0, 0] });
}

function nearest(truth: TruePose[], timeS: number): TruePose | undefined {
  let low = 0;
  let high = truth.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (truth[middle].timeS < timeS) low = middle + 1;
    else high = middle;
  }
  const gap = (pose: TruePose | undefined) => (pose ? Math.abs(pose.timeS - timeS) : Infinity);
  const best = gap(truth[low - 1]) < gap(truth[low]) ? truth[low - 1] : truth[low];
  return gap(best) <= CLOSE_S ? best : undefined;
}
