import {
  BufferAttribute, DynamicDrawUsage, InstancedBufferAttribute, InstancedBufferGeometry, LineSegments,
  type RawShaderMaterial, Sphere,
} from 'three';
import type { KeyframeStore } from '../model/keyframe_store';
import { worthDrawing } from './detail';
import { enclose } from './enclose';
import { TILE_KEYFRAMES, spreadOrder } from './tile_order';

const CORNERS: [number, number, number][] = [[-0.6, -0.45, 0.7], [0.6, -0.45, 0.7], [0.6, 0.45, 0.7], [-0.6, 0.45, 0.7]];
/** A camera that looks along +z: four edges from its centre, and the picture's frame. */
export const FRUSTUM = new Float32Array(
  CORNERS.flatMap((corner, i) => [0, 0, 0, ...corner, ...corner, ...CORNERS[(i + 1) % 4]]),
);
/** The farthest corner, of the largest size to which the shader stretches a frustum of size 1. */
const REACH = 3 * Math.hypot(...CORNERS[0]);
const BYTES = 32;
/** A frustum is at least some 7 by 5 pixels: more of them on a tile's disc would be one grey. */
const FRUSTA_PER_PIXEL = 0.25;
const FEWEST_FRUSTA = 16;

/** One draw call: the frusta of a tile's keyframes, of which a prefix is drawn. */
export class KeyframeTile {
  readonly object: LineSegments<InstancedBufferGeometry, RawShaderMaterial>;
  private readonly places = new InstancedBufferAttribute(new Float32Array(TILE_KEYFRAMES * 4), 4);
  private readonly turns = new InstancedBufferAttribute(new Float32Array(TILE_KEYFRAMES * 4), 4);
  private readonly sphere = new Sphere();
  private count = 0;

  constructor(material: RawShaderMaterial) {
    const geometry = new InstancedBufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(FRUSTUM, 3));
    geometry.setAttribute('place', this.places.setUsage(DynamicDrawUsage));
    geometry.setAttribute('turn', this.turns.setUsage(DynamicDrawUsage));
    geometry.boundingSphere = new Sphere();
    this.object = new LineSegments(geometry, material);
    this.object.matrixAutoUpdate = false;
  }

  /** Takes over the store's slots from `first` on. Returns the bytes that go to the GPU. */
  write(store: KeyframeStore, first: number, count: number): number {
    this.count = count;
    spreadOrder(count).forEach((slot, i) => {
      const from = 4 * (first + slot);
      for (let k = 0; k < 4; k++) {
        this.places.array[4 * i + k] = store.centres[from + k];
        this.turns.array[4 * i + k] = store.rotations[from + k];
      }
    });
    for (const attribute of [this.places, this.turns]) {
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, count * 4);
      attribute.needsUpdate = true;
    }
    enclose(this.places.array as Float32Array, 4, 0, count).getBoundingSphere(this.sphere);
    return count * BYTES;
  }

  /** Chooses how many frusta of a size are drawn: fewer from afar, and fewer in a hurry. */
  setDetail(fraction: number, size: number, pixelsPerUnit: (sphere: Sphere) => number): number {
    const bounds = this.object.geometry.boundingSphere!.copy(this.sphere);
    bounds.radius += REACH * size;
    const radiusPx = bounds.radius * pixelsPerUnit(bounds);
    const drawn = worthDrawing(this.count, fraction, radiusPx, FRUSTA_PER_PIXEL, FEWEST_FRUSTA);
    this.object.geometry.instanceCount = drawn;
    return drawn;
  }

  dispose(): void {
    this.object.removeFromParent();
    this.object.geometry.dispose();
  }
}
