import {
  BufferAttribute, DynamicDrawUsage, InstancedBufferAttribute, InstancedBufferGeometry, LineSegments,
  type RawShaderMaterial,
} from 'three';
import type { KeyframeStore } from '../model/keyframe_store';
import { Lines } from './lines';

const CORNERS: [number, number, number][] = [[-0.6, -0.45, 0.7], [0.6, -0.45, 0.7], [0.6, 0.45, 0.7], [-0.6, 0.45, 0.7]];
/** A camera that looks along +z: four edges from its centre, and the picture's frame. */
export const FRUSTUM = new Float32Array(
  CORNERS.flatMap((corner, i) => [0, 0, 0, ...corner, ...corner, ...CORNERS[(i + 1) % 4]]),
);

/** The keyframes of one local map as frusta in one instanced draw, and their path in another. */
export class KeyframesView {
  readonly frusta: LineSegments<InstancedBufferGeometry, RawShaderMaterial>;
  readonly path: Lines;
  private shownEdits = -1;

  constructor(public store: KeyframeStore, material: RawShaderMaterial, pathMaterial: RawShaderMaterial) {
    this.frusta = new LineSegments(new InstancedBufferGeometry(), material);
    this.frusta.frustumCulled = false;
    this.frusta.matrixAutoUpdate = false;
    this.path = new Lines(pathMaterial, 3);
  }

  /** Takes over what changed. Returns the bytes that go to the GPU. */
  sync(store: KeyframeStore): number {
    if (store === this.store && store.edits === this.shownEdits) return 0;
    const bytes = this.syncFrusta(store) + this.syncPath(store);
    this.store = store;
    this.shownEdits = store.edits;
    return bytes;
  }

  dispose(): void {
    this.frusta.geometry.dispose();
    this.frusta.material.dispose();
    this.path.dispose();
  }

  private syncFrusta(store: KeyframeStore): number {
    let geometry = this.frusta.geometry;
    const places = geometry.getAttribute('place') as InstancedBufferAttribute | undefined;
    if (places?.array !== store.centres) {
      geometry = this.attach(store);
      store.dirty.clear();
    }
    geometry.instanceCount = store.count;
    let bytes = places?.array === store.centres ? 0 : store.count * 32;
    for (const { start, end } of store.dirty.take(store.count)) {
      for (const name of ['place', 'turn']) {
        const attribute = geometry.getAttribute(name) as InstancedBufferAttribute;
        attribute.addUpdateRange(start * 4, (end - start) * 4);
        attribute.needsUpdate = true;
      }
      bytes += (end - start) * 32;
    }
    return bytes;
  }

  private attach(store: KeyframeStore): InstancedBufferGeometry {
    this.frusta.geometry.dispose();
    const geometry = new InstancedBufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(FRUSTUM, 3));
    geometry.setAttribute('place', new InstancedBufferAttribute(store.centres, 4).setUsage(DynamicDrawUsage));
    geometry.setAttribute('turn', new InstancedBufferAttribute(store.rotations, 4).setUsage(DynamicDrawUsage));
    this.frusta.geometry = geometry;
    return geometry;
  }

  private syncPath(store: KeyframeStore): number {
    const slots = store.slotsByTime();
    const path = this.path.array(slots.length);
    for (let i = 0; i < slots.length; i++) {
      const at = slots[i] * 4;
      path[3 * i] = store.centres[at];
      path[3 * i + 1] = store.centres[at + 1];
      path[3 * i + 2] = store.centres[at + 2];
    }
    return this.path.commit(slots.length);
  }
}

/** Half of the usual step between keyframes: frusta of this size don't run into each other. */
export function frustumSize(store: KeyframeStore): number {
  const slots = store.slotsByTime().slice(-200);
  const steps: number[] = [];
  for (let i = 1; i < slots.length; i++) {
    const [a, b] = [slots[i - 1] * 4, slots[i] * 4];
    const c = store.centres;
    steps.push(Math.hypot(c[a] - c[b], c[a + 1] - c[b + 1], c[a + 2] - c[b + 2]));
  }
  steps.sort((a, b) => a - b);
  return 0.6 * (steps[steps.length >> 1] || 1);
}
