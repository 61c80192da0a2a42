import type { Keyframe } from '@gen/corbslam/v1/resources_pb';
import { hexId } from './ids';
import { count, many } from './texts';
import type { PointStore } from './point_store';
import type { Vec3 } from './vector';

/** A map point by its name: its local map and its number there. */
export interface Landmark {
  localMap: string;
  index: number;
}

/** Which landmarks a keyframe sees, and which of its keypoints do. */
export interface Sights {
  /** Each once. */
  landmarks: Landmark[];
  /** Of so many keypoints. */
  keypoints: number;
  seeing: ReadonlySet<number>;
}

/** Undefined: the store says that it sees some, but not which. */
export function sightsOf({ sights, keypoints, observedPoints, payload }: Keyframe): Sights | undefined {
  if (sights.length === 0 && observedPoints > 0) return undefined;
  const landmarks = new Map<string, Landmark>();
  for (const { localMap, point } of sights) {
    const one = { localMap: hexId(localMap), index: point };
    landmarks.set(`${one.localMap}/${one.index}`, one);
  }
  return {
    landmarks: [...landmarks.values()], keypoints: payload?.features?.xPx64.length || keypoints,
    seeing: new Set(sights.map(({ keypoint }) => keypoint)),
  };
}

/** Landmarks that a map has, with their places in their local maps' frames; the rest are counted. */
export function splitLandmarks(
  landmarks: readonly Landmark[], pointsOf: (localMap: string) => PointStore | undefined,
): { known: (Landmark & { position: Vec3 })[]; missing: number } {
  const known = landmarks.flatMap((landmark) => {
    const position = pointsOf(landmark.localMap)?.position(landmark.index);
    return position ? [{ ...landmark, position }] : [];
  });
  return { known, missing: landmarks.length - known.length };
}

export function sightsText({ seeing, keypoints }: Sights): string {
  return `${count(seeing.size)} of ${many(keypoints, 'keypoint')} ${seeing.size === 1 ? 'sees' : 'see'} a landmark`;
}

/** How many of the landmarks are highlighted in the map; `isPast`: it is one of the past. */
export function highlightText({ landmarks }: Sights, missing: number, isPast: boolean): string {
  if (landmarks.length === 0) return 'It sees no landmark.';
  const shown = `${count(landmarks.length - missing)} of its ${many(landmarks.length, 'landmark')} highlighted in the map`;
  const why = isPast ? 'the past that is shown does not have' : 'this page’s map does not have';
  return missing > 0 ? `${shown}; ${count(missing)} ${why}.` : `${shown}.`;
}
