import { type Object3D, type Vector3 } from 'three';
import type { SceneColours } from '../model/palette';
import { Lines } from './lines';
import { type SharedUniforms, setColour } from './materials';

/** The line between the two places whose distance is asked for, over everything. */
export class MeasureView {
  private readonly lines: Lines;

  constructor(parent: Object3D, uniforms: SharedUniforms) {
    this.lines = new Lines(uniforms.lines(), 6);
    this.lines.material.depthTest = false;
    this.lines.material.uniforms.widthPx.value = 3;
    this.lines.mesh.renderOrder = 5;
    parent.add(this.lines.mesh);
  }

  paint({ selected }: SceneColours): void {
    setColour(this.lines.material, selected);
  }

  show(from: Vector3 | undefined, to: Vector3 | undefined): void {
    const array = this.lines.array(1);
    if (from && to) {
      from.toArray(array, 0);
      to.toArray(array, 3);
    }
    this.lines.commit(from && to ? 1 : 0);
  }
}
