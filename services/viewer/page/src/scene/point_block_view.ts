import { BufferAttribute, BufferGeometry, DynamicDrawUsage, type Material, Points, Sphere, Vector3 } from 'three';
import { POINT_FLOATS, type PointBlock } from '../model/point_block';

const BYTES = POINT_FLOATS * 4;
/** More points than this on a pixel of a block's disc would hide each other. */
const POINTS_PER_PIXEL = 0.4;
const FEWEST_POINTS = 200;

/** One draw call: a block of points, of which a prefix is drawn. */
export class PointBlockView {
  readonly object: Points;
  private attribute: BufferAttribute;
  private boundsEdits = -1;
  private readonly sphere = new Sphere();

  constructor(readonly block: PointBlock, material: Material) {
    const geometry = new BufferGeometry();
    this.attribute = this.attach(geometry);
    geometry.boundingSphere = this.sphere;
    this.object = new Points(geometry, material);
    this.object.matrixAutoUpdate = false;
  }

  /** Hands changed spans to the GPU. Returns their bytes. */
  sync(): number {
    const { block } = this;
    if (this.attribute.array !== block.columns) {
      this.object.geometry.dispose();
      this.attribute = this.attach(this.object.geometry);
      block.dirty.clear();
      return block.count * BYTES;
    }
    let bytes = 0;
    for (const { start, end } of block.dirty.take(block.count)) {
      this.attribute.addUpdateRange(start * POINT_FLOATS, (end - start) * POINT_FLOATS);
      this.attribute.needsUpdate = true;
      bytes += (end - start) * BYTES;
    }
    return bytes;
  }

  /** Chooses how many points are drawn: fewer from afar, and fewer in a hurry. */
  setDetail(fraction: number, pixelsPerUnit: (sphere: Sphere) => number): number {
    this.updateBounds();
    const radiusPx = this.sphere.radius * pixelsPerUnit(this.sphere);
    const enough = FEWEST_POINTS + POINTS_PER_PIXEL * Math.PI * radiusPx * radiusPx;
    const drawn = Math.ceil(Math.min(this.block.count, enough) * fraction);
    this.object.geometry.setDrawRange(0, drawn);
    return drawn;
  }

  dispose(): void {
    this.object.geometry.dispose();
  }

  private attach(geometry: BufferGeometry): BufferAttribute {
    const attribute = new BufferAttribute(this.block.columns, POINT_FLOATS);
    attribute.setUsage(DynamicDrawUsage);
    geometry.setAttribute('position', attribute);
    return attribute;
  }

  private updateBounds(): void {
    if (this.boundsEdits === this.block.edits) return;
    this.boundsEdits = this.block.edits;
    const { columns, count } = this.block;
    const low = new Vector3(Infinity, Infinity, Infinity);
    const high = new Vector3(-Infinity, -Infinity, -Infinity);
    const at = new Vector3();
    for (let i = 0; i < count; i++) {
      at.fromArray(columns, i * POINT_FLOATS);
      low.min(at);
      high.max(at);
    }
    if (count === 0) return void this.sphere.set(at, 0);
    this.sphere.center.addVectors(low, high).multiplyScalar(0.5);
    this.sphere.radius = low.distanceTo(high) / 2;
  }
}
