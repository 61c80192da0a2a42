import type { Overlap } from '@gen/corbslam/v1/overlap_pb';
import { Matrix4, Vector3 } from 'three';
import type { KeyframeId } from '../model/ids';
import type { LocalMapModel } from '../model/local_map';
import type { MapView } from './map_view';
import type { ShownOverlap } from './overlaps_view';
import type { Viewport } from './viewport';

const KEYFRAME_REACH_PX = 14;
const OVERLAP_REACH_PX = 6;

/** The keyframe whose centre is seen nearest to a place on the screen. */
export function pickKeyframe(
  map: MapView, viewport: Viewport, x: number, y: number, isVisible: (localMap: LocalMapModel) => boolean,
): KeyframeId | undefined {
  let best: KeyframeId | undefined;
  let reach = KEYFRAME_REACH_PX;
  const at = new Vector3();
  for (const { model, placement } of map.views.values()) {
    if (!isVisible(model)) continue;
    const worldFromMap = new Matrix4().multiplyMatrices(map.root.matrixWorld, placement.matrix);
    for (let slot = 0; slot < model.keyframes.count; slot++) {
      const seen = viewport.project(at.fromArray(model.keyframes.centres, 4 * slot).applyMatrix4(worldFromMap));
      const distance = seen ? Math.hypot(seen.x - x, seen.y - y) : Infinity;
      if (distance >= reach) continue;
      reach = distance;
      best = { localMap: model.id, index: model.keyframes.indices[slot] };
    }
  }
  return best;
}

/** The overlap whose line is seen nearest to a place on the screen. */
export function pickOverlap(shown: ShownOverlap[], viewport: Viewport, x: number, y: number): Overlap | undefined {
  let best: Overlap | undefined;
  let reach = OVERLAP_REACH_PX;
  for (const { overlap, from, to } of shown) {
    const [a, b] = [viewport.project(from), viewport.project(to)];
    if (!a || !b) continue;
    const distance = distanceToSegment(x, y, a, b);
    if (distance < reach) [reach, best] = [distance, overlap];
  }
  return best;
}

function distanceToSegment(x: number, y: number, a: { x: number; y: number }, b: { x: number; y: number }): number {
  const [dx, dy] = [b.x - a.x, b.y - a.y];
  const length2 = dx * dx + dy * dy;
  const t = length2 > 0 ? Math.min(1, Math.max(0, ((x - a.x) * dx + (y - a.y) * dy) / length2)) : 0;
  return Math.hypot(x - a.x - t * dx, y - a.y - t * dy);
}
