import {
  BufferAttribute, DynamicDrawUsage, InstancedBufferGeometry, InstancedInterleavedBuffer,
  InterleavedBufferAttribute, Mesh, type RawShaderMaterial,
} from 'three';

const CORNERS = new Float32Array([0, -1, 0, 1, -1, 0, 1, 1, 0, 0, 1, 0]);
const TRIANGLES = [0, 1, 2, 0, 2, 3];

/** Wide lines in one draw call: connected ones (`stride` 3) or pairs of points (`stride` 6). */
export class Lines {
  readonly mesh: Mesh<InstancedBufferGeometry, RawShaderMaterial>;
  private buffer: InstancedInterleavedBuffer | undefined;

  constructor(readonly material: RawShaderMaterial, private readonly stride: 3 | 6) {
    this.mesh = new Mesh(new InstancedBufferGeometry(), material);
    this.mesh.frustumCulled = false;
    this.mesh.matrixAutoUpdate = false;
    this.mesh.visible = false;
  }

  /** Room for so many points, or pairs; what is in it is kept by the caller. */
  array(count: number): Float32Array {
    const floats = count * this.stride + 3;
    if (!this.buffer || this.buffer.array.length < floats) this.allocate(2 * floats);
    return this.buffer!.array as Float32Array;
  }

  /** Shows what was written to `array`, of which only some points, or pairs, changed. Returns their bytes. */
  commit(count: number, start = 0, end = count): number {
    const segments = this.stride === 3 ? Math.max(0, count - 1) : count;
    this.mesh.visible = segments > 0;
    this.mesh.geometry.instanceCount = segments;
    if (!this.buffer || end <= start) return 0;
    // What was not drawn since it changed is still to be handed over.
    const [waiting] = this.buffer.updateRanges;
    const from = Math.min(start * this.stride, waiting?.start ?? Infinity);
    const to = Math.max(end * this.stride, waiting ? waiting.start + waiting.count : 0);
    this.buffer.clearUpdateRanges();
    this.buffer.addUpdateRange(from, to - from);
    this.buffer.needsUpdate = true;
    return (end - start) * this.stride * 4;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.material.dispose();
  }

  private allocate(floats: number): void {
    this.mesh.geometry.dispose();
    const geometry = new InstancedBufferGeometry();
    this.buffer = new InstancedInterleavedBuffer(new Float32Array(floats), this.stride, 1);
    this.buffer.setUsage(DynamicDrawUsage);
    geometry.setAttribute('position', new BufferAttribute(CORNERS, 3));
    geometry.setAttribute('start', new InterleavedBufferAttribute(this.buffer, 3, 0));
    geometry.setAttribute('end', new InterleavedBufferAttribute(this.buffer, 3, 3));
    geometry.setIndex(TRIANGLES);
    this.mesh.geometry = geometry;
  }
}
