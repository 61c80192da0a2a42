import { Box3, BufferAttribute, BufferGeometry, DynamicDrawUsage, type Material, Points, Sphere } from 'three';
import { POINT_FLOATS, type PointBlock } from '../model/point_block';
import { worthDrawing } from './detail';
import { enclose } from './enclose';

const BYTES = POINT_FLOATS * 4;
/** More points than this on a pixel of a block's disc would hide each other. */
const POINTS_PER_PIXEL = 0.4;
const FEWEST_POINTS = 200;
const MOST_SPANS = 64;

/** One draw call: a block of points, of which a prefix is drawn. */
export class PointBlockView {
  readonly object: Points;
  private attribute: BufferAttribute;
  /** Made once somebody wants to see it. */
  private observations: BufferAttribute | undefined;
  private readonly box = new Box3();
  private readonly sphere = new Sphere();

  constructor(readonly block: PointBlock, material: Material) {
    const geometry = new BufferGeometry();
    geometry.boundingSphere = this.sphere;
    this.attribute = this.attach(geometry);
    this.object = new Points(geometry, material);
    this.object.matrixAutoUpdate = false;
  }

  /** Hands changed spans to the GPU. Returns their bytes. */
  sync(): number {
    const { block } = this;
    if (this.attribute.array !== block.columns) {
      this.object.geometry.dispose();
      this.attribute = this.attach(this.object.geometry);
      if (this.observations) this.carryObservations(true);
      block.dirty.clear();
      return block.count * this.pointBytes;
    }
    const spans = block.dirty.take(block.count);
    // What is not drawn is not uploaded either, and its spans gather.
    if (this.attribute.updateRanges.length > MOST_SPANS) spans.splice(0, spans.length, { start: 0, end: block.count });
    let bytes = 0;
    for (const { start, end } of spans) {
      if (end - start === block.count) this.attribute.clearUpdateRanges();
      this.attribute.addUpdateRange(start * POINT_FLOATS, (end - start) * POINT_FLOATS);
      this.attribute.needsUpdate = true;
      this.updateObservations(start, end);
      this.widen(start, end);
      bytes += (end - start) * this.pointBytes;
    }
    return bytes;
  }

  /** From now on the GPU has how many keyframes see each point. */
  carryObservations(isAnew = false): void {
    if (this.observations && !isAnew) return;
    this.observations = new BufferAttribute(this.block.observations, 1);
    this.observations.setUsage(DynamicDrawUsage);
    this.object.geometry.setAttribute('observations', this.observations);
  }

  /** Chooses how many points are drawn: fewer from afar, and fewer in a hurry. */
  setDetail(fraction: number, pixelsPerUnit: (sphere: Sphere) => number): number {
    const radiusPx = this.sphere.radius * pixelsPerUnit(this.sphere);
    const drawn = worthDrawing(this.block.count, fraction, radiusPx, POINTS_PER_PIXEL, FEWEST_POINTS);
    this.object.geometry.setDrawRange(0, drawn);
    return drawn;
  }

  dispose(): void {
    this.object.geometry.dispose();
  }

  private get pointBytes(): number {
    return this.observations ? BYTES + 1 : BYTES;
  }

  private updateObservations(start: number, end: number): void {
    if (!this.observations) return;
    if (end - start === this.block.count) this.observations.clearUpdateRanges();
    this.observations.addUpdateRange(start, end - start);
    this.observations.needsUpdate = true;
  }

  private attach(geometry: BufferGeometry): BufferAttribute {
    const attribute = new BufferAttribute(this.block.columns, POINT_FLOATS);
    attribute.setUsage(DynamicDrawUsage);
    geometry.setAttribute('position', attribute);
    this.widen(0, this.block.count);
    return attribute;
  }

  /** Bounds are widened by what changed, and made anew only with all of a block. */
  private widen(start: number, end: number): void {
    if (end - start === this.block.count) this.box.makeEmpty();
    enclose(this.block.columns, POINT_FLOATS, start, end, this.box).getBoundingSphere(this.sphere);
  }
}
