import { Box3, Group, Vector3 } from 'three';
import type { KeyframeId } from '../model/ids';
import { type GroundBox, type Plot, layOut } from '../model/layout';
import { withPoints } from '../model/extent';
import type { KeyframeStore } from '../model/keyframe_store';
import type { LocalMapModel } from '../model/local_map';
import type { IslandChange, MapModel } from '../model/map_model';
import type { Vec3 } from '../model/vector';
import { LocalMapView } from './local_map_view';
import type { SharedUniforms } from './materials';

/** The global layer: all local maps, each in its island's frame, islands side by side. */
export class MapView {
  /** Turns the first camera's frame (y down, z ahead) so that y is up. */
  readonly root = new Group();
  readonly views = new Map<string, LocalMapView>();
  plots = new Map<string, Plot>();
  /** Grows when a keyframe may be seen elsewhere. */
  version = 0;

  constructor(private readonly uniforms: SharedUniforms) {
    this.root.rotation.x = Math.PI;
    this.root.updateMatrixWorld(true);
  }

  /** Follows the model; returns bytes for the GPU. */
  sync(model: MapModel, changes: IslandChange[], nowMs: number): number {
    for (const [id, view] of this.views) if (!model.localMaps.has(id)) this.forget(id, view);
    this.version++;
    let bytes = 0;
    for (const localMap of model.localMaps.values()) {
      if (localMap.keyframes.count + localMap.points.count > 0) bytes += this.viewOf(localMap).sync(localMap);
    }
    this.arrange(model, changes, nowMs);
    this.uniforms.pointAges.value = Math.max(1, model.pointArrivals);
    this.uniforms.keyframeAges.value = Math.max(1, model.keyframeArrivals);
    return bytes;
  }

  /** Moves what moves. Returns whether anything did. */
  advance(nowMs: number): boolean {
    let moves = false;
    for (const view of this.views.values()) moves = view.advance(nowMs) || moves;
    if (moves) this.version++;
    return moves;
  }

  /** Where a keyframe is seen. */
  world(id: KeyframeId): Vector3 | undefined {
    const view = this.views.get(id.localMap);
    const pose = view?.model.keyframes.pose(id.index);
    if (!view || !pose) return undefined;
    return new Vector3(...pose.centre).applyMatrix4(view.placement.matrix).applyMatrix4(this.root.matrixWorld);
  }

  /** Where a place of an island's frame is seen, once nothing moves; undefined: there is no such island. */
  worldOf(island: string, place: Vec3): Vector3 | undefined {
    if (!this.plots.has(island)) return undefined;
    return new Vector3(...place).add(this.offset(island)).applyMatrix4(this.root.matrixWorld);
  }

  /** Of some local map the keyframes alone leave gaps in the path. */
  get hasGaps(): boolean {
    return [...this.views.values()].some(({ keyframes }) => keyframes.path.hasGaps);
  }

  /** Around the keyframes of some local maps, where they will be once nothing moves. */
  bounds(wanted: (localMap: LocalMapModel) => boolean): Box3 {
    return this.around(wanted, keyframeBox);
  }

  /** As `bounds`, and around the points that belong to them, where those are seen. */
  extent(wanted: (localMap: LocalMapModel) => boolean, points: boolean): Box3 {
    return this.around(wanted, points ? pointBox : keyframeBox);
  }

  /** A local map is on its way to where it belongs. */
  get isMoving(): boolean {
    return [...this.views.values()].some(({ placement }) => placement.isMoving);
  }

  private around(wanted: (localMap: LocalMapModel) => boolean, boxOf: (localMap: LocalMapModel) => Box3): Box3 {
    const box = new Box3();
    for (const { model } of this.views.values()) {
      if (wanted(model) && model.keyframes.count > 0) box.union(boxOf(model).translate(this.offset(model.island)));
    }
    return box.isEmpty() ? box : box.applyMatrix4(this.root.matrixWorld);
  }

  private offset(island: string): Vector3 {
    const plot = this.plots.get(island);
    return new Vector3(plot?.offsetX ?? 0, 0, plot?.offsetZ ?? 0);
  }

  private arrange(model: MapModel, changes: IslandChange[], nowMs: number): void {
    const grounds = [...model.islands()].map(([name, members]) => ({
      name, isReference: name === model.globalIsland, box: groundBox(members),
    }));
    this.plots = layOut(grounds.filter(({ box }) => box.minX <= box.maxX), this.plots);
    const changed = new Map(changes.map((change) => [change.localMap, change.oldFromNew]));
    for (const [id, view] of this.views) {
      const target = this.offset(view.model.island);
      if (changed.has(id)) view.placement.reframe(changed.get(id), target, () => view.middle(), nowMs);
      else view.placement.moveTo(target, () => view.middle(), nowMs);
    }
  }

  private viewOf(localMap: LocalMapModel): LocalMapView {
    const known = this.views.get(localMap.id);
    if (known) return known;
    const created = new LocalMapView(this.root, localMap, this.uniforms);
    this.views.set(localMap.id, created);
    return created;
  }

  private forget(id: string, view: LocalMapView): void {
    view.dispose();
    this.views.delete(id);
  }
}

const boxes = new WeakMap<KeyframeStore, { edits: number; box: Box3 }>();

/** Around the keyframes, in their island's frame; reckoned once for each change. */
function keyframeBox({ keyframes }: LocalMapModel): Box3 {
  const known = boxes.get(keyframes);
  if (known?.edits === keyframes.edits) return known.box.clone();
  const box = new Box3();
  const at = new Vector3();
  for (let i = 0; i < keyframes.count; i++) box.expandByPoint(at.fromArray(keyframes.centres, 4 * i));
  boxes.set(keyframes, { edits: keyframes.edits, box });
  return box.clone();
}

/** Around the keyframes and most of the points. */
function pointBox(localMap: LocalMapModel): Box3 {
  const { min, max } = keyframeBox(localMap);
  const { low, high } = withPoints({ low: min.toArray(), high: max.toArray() }, localMap.points);
  return new Box3(new Vector3(...low), new Vector3(...high));
}

function groundBox(members: LocalMapModel[]): GroundBox {
  const box = new Box3();
  for (const member of members) box.union(keyframeBox(member));
  return { minX: box.min.x, maxX: box.max.x, minZ: box.min.z, maxZ: box.max.z };
}
