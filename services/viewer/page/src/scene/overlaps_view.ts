import { type Object3D, Vector3 } from 'three';
import type { Overlap } from '@gen/corbslam/v1/overlap_pb';
import { parseKeyframeName } from '../model/ids';
import { isAccepted } from '../model/texts';
import { Lines } from './lines';
import type { MapView } from './map_view';
import { type SharedUniforms, setColour } from './materials';
import { type SceneColours } from '../model/palette';

/** An overlap whose two keyframes are in the picture. */
export interface ShownOverlap {
  overlap: Overlap;
  from: Vector3;
  to: Vector3;
}

/** Overlaps as lines between their keyframes: accepted ones, refused ones, and the chosen one. */
export class OverlapsView {
  shown: ShownOverlap[] = [];
  private readonly accepted: Lines;
  private readonly refused: Lines;
  private readonly chosen: Lines;

  constructor(parent: Object3D, uniforms: SharedUniforms) {
    this.accepted = new Lines(uniforms.lines(), 6);
    this.refused = new Lines(uniforms.lines(), 6);
    this.chosen = new Lines(uniforms.lines(), 6);
    this.accepted.material.uniforms.widthPx.value = 2;
    this.refused.material.uniforms.widthPx.value = 1.5;
    this.refused.material.uniforms.dashPx.value = 6;
    this.refused.material.uniforms.opacity.value = 0.75;
    this.chosen.material.uniforms.widthPx.value = 5;
    for (const lines of [this.accepted, this.refused, this.chosen]) {
      lines.material.depthTest = false;
      lines.mesh.renderOrder = 2;
      parent.add(lines.mesh);
    }
  }

  paint({ accepted, refused, selected }: SceneColours): void {
    setColour(this.accepted.material, accepted);
    setColour(this.refused.material, refused);
    setColour(this.chosen.material, selected);
  }

  /** Draws what is wanted; keyframes that are not in the picture are passed over. */
  update(overlaps: Overlap[], map: MapView, chosen: Overlap | undefined): void {
    this.shown = overlaps.flatMap((overlap) => shownOverlap(overlap, map) ?? []);
    write(this.accepted, this.shown.filter(({ overlap }) => isAccepted(overlap)));
    const refused = this.shown.filter(({ overlap }) => !isAccepted(overlap));
    // Hundreds of lines over each other would hide the map.
    this.refused.material.uniforms.opacity.value = 0.75 * Math.max(0.12, Math.min(1, 60 / Math.max(1, refused.length)));
    write(this.refused, refused);
    const one = chosen && shownOverlap(chosen, map);
    write(this.chosen, one ? [one] : []);
  }
}

function shownOverlap(overlap: Overlap, map: MapView): ShownOverlap | undefined {
  const [query, candidate] = [parseKeyframeName(overlap.query), parseKeyframeName(overlap.candidate)];
  const from = query && map.world(query);
  const to = candidate && map.world(candidate);
  return from && to ? { overlap, from, to } : undefined;
}

function write(lines: Lines, shown: ShownOverlap[]): void {
  const array = lines.array(shown.length);
  shown.forEach(({ from, to }, i) => {
    from.toArray(array, 6 * i);
    to.toArray(array, 6 * i + 3);
  });
  lines.commit(shown.length);
}
