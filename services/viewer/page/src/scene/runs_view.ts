import type { Object3D } from 'three';
import { type DrivenPath, segmentsOf } from '../model/driven';
import { Lines } from './lines';
import type { MapView } from './map_view';
import { type SharedUniforms, setColour } from './materials';
import { showSegments } from './trajectories';

const WIDTH_PX = 2;
const DASH_PX = 7;

/** Paths that no keyframe of the map stands for: of robots that only localised, and of sessions of which no keyframe is left. */
export class RunsView {
  private readonly shown: { path: DrivenPath; lines: Lines }[] = [];

  constructor(private readonly parent: Object3D, private readonly uniforms: SharedUniforms) {}

  /** Shows these paths instead of those before. */
  show(paths: readonly DrivenPath[]): void {
    for (const { lines } of this.shown.splice(0)) {
      lines.mesh.removeFromParent();
      lines.dispose();
    }
    for (const path of paths) {
      const lines = new Lines(this.uniforms.lines(), 6);
      lines.material.uniforms.widthPx.value = WIDTH_PX;
      lines.material.uniforms.dashPx.value = DASH_PX;
      showSegments(lines, segmentsOf(path));
      this.parent.add(lines.mesh);
      this.shown.push({ path, lines });
    }
  }

  get count(): number {
    return this.shown.length;
  }

  /** Follows the islands to where they are drawn; one that is no more hides its paths. */
  place(map: MapView): void {
    for (const { path, lines } of this.shown) {
      const plot = map.plots.get(path.island);
      lines.mesh.matrix.makeTranslation(plot?.offsetX ?? 0, 0, plot?.offsetZ ?? 0);
      lines.mesh.matrixWorldNeedsUpdate = true;
      lines.mesh.userData.isPlaced = plot !== undefined;
    }
  }

  paint(colourOf: (agent: string) => string, isVisible: (agent: string) => boolean): void {
    for (const { path, lines } of this.shown) {
      setColour(lines.material, colourOf(path.agent));
      lines.mesh.visible = lines.segments > 0 && lines.mesh.userData.isPlaced === true && isVisible(path.agent);
    }
  }
}
