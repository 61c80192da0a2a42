import { Group, Vector3, type Object3D, type RawShaderMaterial } from 'three';
import type { DrivenPath } from '../model/driven';
import type { LocalMapModel } from '../model/local_map';
import type { ColourMode } from '../model/palette';
import { KeyframesView } from './keyframes_view';
import { Lines } from './lines';
import { type SharedUniforms, setColour } from './materials';
import { Placement } from './placement';
import { PointBlockView } from './point_block_view';

/** What of a local map is drawn. */
export interface Shown {
  points: boolean;
  keyframes: boolean;
  paths: boolean;
  frames: boolean;
  colour: ColourMode;
}

/** One local map in the picture: its blocks of points, its keyframes and its paths. */
export class LocalMapView {
  readonly group = new Group();
  readonly placement = new Placement();
  readonly keyframes: KeyframesView;
  /** Where every frame was; filled on demand. */
  readonly frames: Lines;
  readonly blocks: PointBlockView[] = [];
  /** Where all frames were, as far as was asked for. */
  driven: DrivenPath | undefined;
  private readonly pointMaterial: RawShaderMaterial;

  constructor(parent: Object3D, public model: LocalMapModel, uniforms: SharedUniforms) {
    this.pointMaterial = uniforms.points();
    this.keyframes = new KeyframesView(model.keyframes, uniforms.keyframes(), uniforms.lines());
    this.frames = new Lines(uniforms.lines(), 6);
    this.frames.material.uniforms.widthPx.value = 1;
    this.group.matrixAutoUpdate = false;
    this.group.add(this.keyframes.frusta, this.keyframes.path.lines.mesh, this.frames.mesh);
    parent.add(this.group);
  }

  /** Takes over what changed; returns bytes for the GPU. */
  sync(model: LocalMapModel): number {
    this.model = model;
    let bytes = this.syncPath();
    model.points.blocks.forEach((block, i) => {
      if (this.blocks[i]?.block !== block) this.replaceBlock(i, new PointBlockView(block, this.pointMaterial));
      bytes += this.blocks[i].sync();
    });
    for (const view of this.blocks.splice(model.points.blocks.length)) this.drop(view);
    return bytes;
  }

  /** Frames that were told in another island's frame wait for the next answer. */
  syncPath(): number {
    const { keyframes, island } = this.model;
    return this.keyframes.sync(keyframes, this.driven?.island === island ? this.driven : undefined);
  }

  paint(points: string, lines: string, shown: Shown): void {
    setColour(this.pointMaterial, points);
    setColour(this.keyframes.material, lines);
    setColour(this.keyframes.path.lines.material, lines);
    setColour(this.frames.material, lines);
    for (const block of this.blocks) {
      block.object.visible = shown.points;
      if (shown.colour === 'observations') block.carryObservations();
    }
    this.keyframes.frusta.visible = shown.keyframes;
    this.keyframes.path.lines.mesh.visible = shown.paths;
    this.frames.mesh.visible = shown.frames && this.frames.segments > 0;
  }

  /** The mean of the keyframes' centres, in the local map's frame. */
  middle(): Vector3 {
    const { centres, count } = this.model.keyframes;
    const sum = new Vector3();
    for (let i = 0; i < count; i++) sum.add(new Vector3().fromArray(centres, 4 * i));
    return sum.divideScalar(Math.max(count, 1));
  }

  /** Applies the placement. Returns whether it moves on. */
  advance(nowMs: number): boolean {
    const moves = this.placement.advance(nowMs);
    this.group.matrix.copy(this.placement.matrix);
    this.group.matrixWorldNeedsUpdate = true;
    return moves;
  }

  dispose(): void {
    this.group.removeFromParent();
    for (const view of this.blocks.splice(0)) this.drop(view);
    this.pointMaterial.dispose();
    this.keyframes.dispose();
    this.frames.dispose();
  }

  private replaceBlock(i: number, view: PointBlockView): void {
    if (this.blocks[i]) this.drop(this.blocks[i]);
    this.blocks[i] = view;
    this.group.add(view.object);
  }

  private drop(view: PointBlockView): void {
    view.object.removeFromParent();
    view.dispose();
  }
}
