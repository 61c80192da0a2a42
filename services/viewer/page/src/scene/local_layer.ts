import { Box3, Group, Vector3 } from 'three';
import type { TrajectoryPose } from '@gen/corbslam/v1/resources_pb';
import { type Plot, layOut } from '../model/layout';
import { lastSegment } from '../model/ids';
import { Lines } from './lines';
import { type SharedUniforms, setColour } from './materials';
import { segmentsByLocalMap, showSegments } from './trajectories';

interface LocalTrajectory {
  lines: Lines;
  agent: string;
  box: Box3;
}

/** The local layer: each local map in its own frame, as its robot said, side by side. */
export class LocalLayer {
  readonly root = new Group();
  readonly trajectories = new Map<string, LocalTrajectory>();
  private plots = new Map<string, Plot>();

  constructor(private readonly uniforms: SharedUniforms) {
    this.root.rotation.x = Math.PI;
    this.root.updateMatrixWorld(true);
  }

  update(poses: TrajectoryPose[]): void {
    const agents = new Map(poses.map((pose) => [lastSegment(pose.localMap), lastSegment(pose.agent)]));
    const segments = segmentsByLocalMap(poses);
    for (const id of [...this.trajectories.keys()]) if (!segments.has(id)) this.drop(id);
    for (const [id, values] of segments) this.show(id, agents.get(id) ?? '', values);
    this.arrange();
  }

  paint(colourOf: (agent: string) => string, isVisible: (agent: string) => boolean): void {
    for (const { lines, agent } of this.trajectories.values()) {
      setColour(lines.material, colourOf(agent));
      lines.mesh.visible = isVisible(agent) && lines.segments > 0;
    }
  }

  /** Where labels stand: above the middle of each local map. */
  anchors(): { id: string; agent: string; at: Vector3 }[] {
    return [...this.trajectories].map(([id, { lines, agent, box }]) => ({
      id, agent,
      at: box.getCenter(new Vector3()).setZ(box.max.z).applyMatrix4(lines.mesh.matrix).applyMatrix4(this.root.matrixWorld),
    }));
  }

  bounds(): Box3 {
    const all = new Box3();
    for (const { lines, box } of this.trajectories.values()) {
      if (!box.isEmpty()) all.union(box.clone().applyMatrix4(lines.mesh.matrix));
    }
    return all.isEmpty() ? all : all.applyMatrix4(this.root.matrixWorld);
  }

  private show(id: string, agent: string, values: number[]): void {
    let entry = this.trajectories.get(id);
    if (!entry) {
      entry = { lines: new Lines(this.uniforms.lines(), 6), agent, box: new Box3() };
      this.trajectories.set(id, entry);
      this.root.add(entry.lines.mesh);
    }
    entry.box.setFromArray(values);
    showSegments(entry.lines, values);
  }

  private arrange(): void {
    const islands = [...this.trajectories].filter(([, { box }]) => !box.isEmpty()).map(([name, { box }]) => ({
      name, isReference: false,
      box: { minX: box.min.x, maxX: box.max.x, minZ: box.min.z, maxZ: box.max.z },
    }));
    this.plots = layOut(islands, this.plots, false);
    for (const [id, { lines }] of this.trajectories) {
      const plot = this.plots.get(id);
      lines.mesh.matrix.makeTranslation(plot?.offsetX ?? 0, 0, plot?.offsetZ ?? 0);
      lines.mesh.matrixWorldNeedsUpdate = true;
    }
  }

  private drop(id: string): void {
    const entry = this.trajectories.get(id)!;
    entry.lines.mesh.removeFromParent();
    entry.lines.dispose();
    this.trajectories.delete(id);
  }
}
