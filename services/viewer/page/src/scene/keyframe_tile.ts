import { BufferAttribute, BufferGeometry, DynamicDrawUsage, LineSegments, type RawShaderMaterial, Sphere } from 'three';
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
/** A frustum's vertices are the centre and four corners, as the shader has them. */
const VERTICES = 5;
const EDGES = [0, 1, 1, 2, 0, 2, 2, 3, 0, 3, 3, 4, 0, 4, 4, 1];
const INDEX = Uint16Array.from({ length: TILE_KEYFRAMES * EDGES.length }, (_, i) =>
  VERTICES * Math.floor(i / EDGES.length) + EDGES[i % EDGES.length]);
const FLOATS = 4;
const BYTES = 2 * VERTICES * FLOATS * 4;
/** A frustum is at least some 7 by 5 pixels: more of them on a tile's disc would lie over each other twice. */
const FRUSTA_PER_PIXEL = 0.05;
const FEWEST_FRUSTA = 16;

/**
 * One draw call: the frusta of a tile's keyframes, of which a prefix is drawn. Each has its own
 * vertices, as segments of lines have.
 */
export class KeyframeTile {
  readonly object: LineSegments<BufferGeometry, RawShaderMaterial>;
  private readonly places = column();
  private readonly turns = column();
  private readonly sphere = new Sphere();
  private count = 0;

  constructor(material: RawShaderMaterial) {
    const geometry = new BufferGeometry();
    geometry.setAttribute('place', this.places);
    geometry.setAttribute('turn', this.turns);
    geometry.setIndex(new BufferAttribute(INDEX, 1));
    geometry.boundingSphere = new Sphere();
    this.object = new LineSegments(geometry, material);
    this.object.matrixAutoUpdate = false;
  }

  /** Takes over the store's slots from `first` on. Returns the bytes that go to the GPU. */
  write(store: KeyframeStore, first: number, count: number): number {
    this.count = count;
    const order = spreadOrder(count);
    for (let vertex = 0; vertex < VERTICES * count; vertex++) {
      const from = FLOATS * (first + order[Math.floor(vertex / VERTICES)]);
      for (let k = 0; k < FLOATS; k++) {
        this.places.array[FLOATS * vertex + k] = store.centres[from + k];
        this.turns.array[FLOATS * vertex + k] = store.rotations[from + k];
      }
    }
    for (const attribute of [this.places, this.turns]) {
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, FLOATS * VERTICES * count);
      attribute.needsUpdate = true;
    }
    enclose(this.places.array as Float32Array, FLOATS, 0, VERTICES * count).getBoundingSphere(this.sphere);
    return count * BYTES;
  }

  /** Chooses how many frusta of a size are drawn: fewer from afar, and fewer in a hurry. */
  setDetail(fraction: number, size: number, pixelsPerUnit: (sphere: Sphere) => number): number {
    const bounds = this.object.geometry.boundingSphere!.copy(this.sphere);
    bounds.radius += REACH * size;
    const radiusPx = bounds.radius * pixelsPerUnit(bounds);
    const drawn = worthDrawing(this.count, fraction, radiusPx, FRUSTA_PER_PIXEL, FEWEST_FRUSTA);
    this.object.geometry.setDrawRange(0, drawn * EDGES.length);
    return drawn;
  }

  dispose(): void {
    this.object.removeFromParent();
    this.object.geometry.dispose();
  }
}

function column(): BufferAttribute {
  return new BufferAttribute(new Float32Array(TILE_KEYFRAMES * VERTICES * FLOATS), FLOATS).setUsage(DynamicDrawUsage);
}
