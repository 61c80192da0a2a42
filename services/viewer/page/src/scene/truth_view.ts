import type { Object3D } from 'three';
import type { Plot } from '../model/layout';
import { Lines } from './lines';
import { type SharedUniforms, setColour } from './materials';

/** Where the cameras really were: a dashed line in the reference island's frame. */
export class TruthView {
  private readonly lines: Lines;
  private count = 0;

  constructor(parent: Object3D, uniforms: SharedUniforms) {
    this.lines = new Lines(uniforms.lines(), 6);
    this.lines.material.uniforms.widthPx.value = 2;
    parent.add(this.lines.mesh);
  }

  get isShown(): boolean {
    return this.lines.mesh.visible;
  }

  /** Segments (x, y, z twice each) in the island's frame. */
  show(segments: number[]): void {
    this.count = segments.length / 6;
    this.lines.array(this.count).set(segments);
    this.lines.commit(this.count);
  }

  /** Follows the island to where it is drawn. */
  place(plot: Plot | undefined): void {
    this.lines.mesh.matrix.makeTranslation(plot?.offsetX ?? 0, 0, plot?.offsetZ ?? 0);
    this.lines.mesh.matrixWorldNeedsUpdate = true;
  }

  paint(colour: string, isWanted: boolean): void {
    setColour(this.lines.material, colour);
    this.lines.mesh.visible = isWanted && this.count > 0;
  }
}
