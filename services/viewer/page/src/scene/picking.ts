import type { Overlap } from '@gen/corbslam/v1/overlap_pb';
import { Matrix4, Vector3 } from 'three';
import type { KeyframeId } from '../model/ids';
import { POINT_FLOATS } from '../model/point_block';
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

const POINT_REACH_PX = 6;

/** The keyframe, or the nearest of the points, that is seen at a place on the screen. */
export function pickPlace(
  map: MapView, viewport: Viewport, x: number, y: number, points: boolean, isVisible: (localMap: LocalMapModel) => boolean,
): { at: Vector3; island: string } | undefined {
  const keyframe = pickKeyframe(map, viewport, x, y, isVisible);
  const at = keyframe && map.world(keyframe);
  if (keyframe && at) return { at, island: map.views.get(keyframe.localMap)!.model.island };
  return points ? pickPoint(map, viewport, x, y, isVisible) : undefined;
}

function pickPoint(
  map: MapView, viewport: Viewport, x: number, y: number, isVisible: (localMap: LocalMapModel) => boolean,
): { at: Vector3; island: string } | undefined {
  let best: { at: Vector3; island: string } | undefined;
  let nearest = Infinity;
  const [width, height] = [viewport.element.clientWidth, viewport.element.clientHeight];
  const screen = new Matrix4().multiplyMatrices(viewport.camera.projectionMatrix, viewport.camera.matrixWorldInverse);
  for (const { model, placement } of map.views.values()) {
    if (!isVisible(model)) continue;
    const worldFromMap = new Matrix4().multiplyMatrices(map.root.matrixWorld, placement.matrix);
    const { elements: m } = new Matrix4().multiplyMatrices(screen, worldFromMap);
    for (const { columns, count } of model.points.blocks) {
      for (let i = 0; i < count; i++) {
        const [px, py, pz] = [columns[POINT_FLOATS * i], columns[POINT_FLOATS * i + 1], columns[POINT_FLOATS * i + 2]];
        const w = m[3] * px + m[7] * py + m[11] * pz + m[15];
        if (w <= 0 || w >= nearest) continue;
        const seenX = ((m[0] * px + m[4] * py + m[8] * pz + m[12]) / w + 1) * 0.5 * width;
        const seenY = (1 - (m[1] * px + m[5] * py + m[9] * pz + m[13]) / w) * 0.5 * height;
        if (Math.hypot(seenX - x, seenY - y) > POINT_REACH_PX) continue;
        nearest = w;
        best = { at: new Vector3(px, py, pz).applyMatrix4(worldFromMap), island: model.island };
      }
    }
  }
  return best;
}
