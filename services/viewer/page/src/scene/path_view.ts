import { type RawShaderMaterial, Sphere } from 'three';
import type { DrivenPath } from '../model/driven';
import type { KeyframeStore } from '../model/keyframe_store';
import { type Way, wayOf } from '../model/way';
import { pathTolerance } from './detail';
import { enclose } from './enclose';
import { Lines } from './lines';
import { simplify } from './simplify';

/** The way along one local map: as many corners of it as can be told apart on the screen. */
export class PathView {
  readonly lines: Lines;
  private way: Way = { points: new Float32Array(0), count: 0, begins: [0], hasGaps: false };
  private readonly sphere = new Sphere();
  private isShown = false;
  private tolerance = 0;

  constructor(material: RawShaderMaterial) {
    this.lines = new Lines(material, 6);
  }

  /** The keyframes alone leave gaps. */
  get hasGaps(): boolean {
    return this.way.hasGaps;
  }

  /** Takes over what changed; `driven`: where the frames were, where that is known. */
  sync(store: KeyframeStore, driven: DrivenPath | undefined): void {
    this.way = wayOf(store, driven);
    enclose(this.way.points, 3, 0, this.way.count).getBoundingSphere(this.sphere);
    this.isShown = false;
  }

  /** Chooses the corners that are drawn; `isHurried`: few. Returns the bytes that go to the GPU. */
  setDetail(isHurried: boolean, pixelsPerUnit: (sphere: Sphere) => number): number {
    const tolerance = pathTolerance(pixelsPerUnit(this.sphere), isHurried);
    if (this.isShown && tolerance === this.tolerance) return 0;
    this.isShown = true;
    this.tolerance = tolerance;
    return this.show(this.corners(tolerance));
  }

  /** Pairs of places that are joined. */
  private corners(tolerance: number): number[] {
    const { points, count, begins } = this.way;
    const pairs: number[] = [];
    begins.forEach((begin, i) => {
      const end = begins[i + 1] ?? count;
      const kept = tolerance > 0 ? simplify(points.subarray(3 * begin), end - begin, tolerance) : undefined;
      const corners = kept?.length ?? end - begin;
      for (let k = 1; k < corners; k++) pairs.push(begin + (kept ? kept[k - 1] : k - 1), begin + (kept ? kept[k] : k));
    });
    return pairs;
  }

  private show(pairs: number[]): number {
    const count = pairs.length / 2;
    const wasVisible = this.lines.mesh.visible;
    const array = this.lines.array(count);
    let [start, end] = [count, 0];
    for (let i = 0; i < count; i++) {
      const isOther = copyPlace(this.way.points, 3 * pairs[2 * i], array, 6 * i);
      if (!copyPlace(this.way.points, 3 * pairs[2 * i + 1], array, 6 * i + 3) && !isOther) continue;
      start = Math.min(start, i);
      end = i + 1;
    }
    const bytes = this.lines.commit(count, start, end);
    this.lines.mesh.visible = wasVisible;
    return bytes;
  }
}

/** Returns whether there was another place. */
function copyPlace(from: Float32Array, at: number, to: Float32Array, target: number): boolean {
  let isOther = false;
  for (let k = 0; k < 3; k++) {
    isOther ||= to[target + k] !== from[at + k];
    to[target + k] = from[at + k];
  }
  return isOther;
}
