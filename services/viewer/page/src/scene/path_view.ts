import { type RawShaderMaterial, Sphere } from 'three';
import type { KeyframeStore } from '../model/keyframe_store';
import { pathTolerance } from './detail';
import { enclose } from './enclose';
import { Lines } from './lines';
import { simplify } from './simplify';

/** The way through one local map's keyframes: as many corners of it as can be told apart on the screen. */
export class PathView {
  readonly lines: Lines;
  private points = new Float32Array(0);
  private count = 0;
  private readonly sphere = new Sphere();
  private isShown = false;
  private tolerance = 0;

  constructor(material: RawShaderMaterial) {
    this.lines = new Lines(material, 3);
  }

  /** Takes over what changed. */
  sync(store: KeyframeStore): void {
    const slots = store.slotsByTime();
    this.count = slots.length;
    if (this.points.length < 3 * this.count) this.points = new Float32Array(6 * this.count);
    for (let i = 0; i < this.count; i++) copyPlace(store.centres, 4 * slots[i], this.points, 3 * i);
    enclose(this.points, 3, 0, this.count).getBoundingSphere(this.sphere);
    this.isShown = false;
  }

  /** Chooses the corners that are drawn; `isHurried`: few. Returns the bytes that go to the GPU. */
  setDetail(isHurried: boolean, pixelsPerUnit: (sphere: Sphere) => number): number {
    const tolerance = pathTolerance(pixelsPerUnit(this.sphere), isHurried);
    if (this.isShown && tolerance === this.tolerance) return 0;
    this.isShown = true;
    this.tolerance = tolerance;
    return this.show(tolerance > 0 ? simplify(this.points, this.count, tolerance) : undefined);
  }

  private show(corners: number[] | undefined): number {
    const count = corners?.length ?? this.count;
    const wasVisible = this.lines.mesh.visible;
    const array = this.lines.array(count);
    let [start, end] = [count, 0];
    for (let i = 0; i < count; i++) {
      if (!copyPlace(this.points, 3 * (corners ? corners[i] : i), array, 3 * i)) continue;
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
