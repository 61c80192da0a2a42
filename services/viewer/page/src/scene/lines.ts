import {
  BufferAttribute, BufferGeometry, DynamicDrawUsage, InterleavedBuffer, InterleavedBufferAttribute, Mesh,
  type RawShaderMaterial,
} from 'three';

/** Of a segment: four vertices, each with where it starts and ends. */
const VERTICES = 4;
const VERTEX_FLOATS = 6;
const SEGMENT_FLOATS = VERTICES * VERTEX_FLOATS;
const TRIANGLES = [0, 1, 2, 0, 2, 3];

/**
 * Wide lines in one draw call: connected ones (`stride` 3) or pairs of points (`stride` 6). Each
 * segment has its own vertices: drawing thousands of instances of four costs some graphics
 * processors, and rendering without one, many times as much.
 */
export class Lines {
  readonly mesh: Mesh<BufferGeometry, RawShaderMaterial>;
  /** So many are shown. */
  segments = 0;
  private points = new Float32Array(0);
  private buffer: InterleavedBuffer | undefined;

  constructor(readonly material: RawShaderMaterial, private readonly stride: 3 | 6) {
    this.mesh = new Mesh(new BufferGeometry(), material);
    this.mesh.frustumCulled = false;
    this.mesh.matrixAutoUpdate = false;
    this.mesh.visible = false;
  }

  /** Room for so many points, or pairs; what is in it is kept by the caller. */
  array(count: number): Float32Array {
    if (this.points.length < count * this.stride) {
      this.points = new Float32Array(2 * count * this.stride);
      this.allocate(2 * count);
    }
    return this.points;
  }

  /** Shows what was written to `array`, of which only some points, or pairs, changed. Returns the bytes for it. */
  commit(count: number, start = 0, end = count): number {
    const before = this.segments;
    this.segments = this.stride === 3 ? Math.max(0, count - 1) : count;
    this.mesh.visible = this.segments > 0;
    this.mesh.geometry.setDrawRange(0, this.segments * TRIANGLES.length);
    // A connected line's point ends the segment before it, too; of one that grew, the last segment is new.
    const first = Math.min(this.stride === 3 ? Math.max(0, start - 1) : start, before);
    const last = Math.min(end, this.segments);
    return this.buffer && last > first ? this.write(this.buffer, first, last) : 0;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.material.dispose();
  }

  private write(buffer: InterleavedBuffer, first: number, last: number): number {
    for (let segment = first; segment < last; segment++) {
      for (let i = 0; i < SEGMENT_FLOATS; i++) {
        buffer.array[segment * SEGMENT_FLOATS + i] = this.points[segment * this.stride + (i % VERTEX_FLOATS)];
      }
    }
    // What was not drawn since it changed is still to be handed over.
    const [waiting] = buffer.updateRanges;
    const from = Math.min(first * SEGMENT_FLOATS, waiting?.start ?? Infinity);
    const to = Math.max(last * SEGMENT_FLOATS, waiting ? waiting.start + waiting.count : 0);
    buffer.clearUpdateRanges();
    buffer.addUpdateRange(from, to - from);
    buffer.needsUpdate = true;
    return (last - first) * SEGMENT_FLOATS * 4;
  }

  private allocate(segments: number): void {
    this.mesh.geometry.dispose();
    const geometry = new BufferGeometry();
    this.buffer = new InterleavedBuffer(new Float32Array(segments * SEGMENT_FLOATS), VERTEX_FLOATS);
    this.buffer.setUsage(DynamicDrawUsage);
    geometry.setAttribute('start', new InterleavedBufferAttribute(this.buffer, 3, 0));
    geometry.setAttribute('end', new InterleavedBufferAttribute(this.buffer, 3, 3));
    const index = Uint32Array.from({ length: segments * TRIANGLES.length }, (_, i) =>
      VERTICES * Math.floor(i / TRIANGLES.length) + TRIANGLES[i % TRIANGLES.length]);
    geometry.setIndex(new BufferAttribute(index, 1));
    this.mesh.geometry = geometry;
    this.segments = 0;
  }
}
