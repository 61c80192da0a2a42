import { Vector3 } from 'three';
import type { MapNames } from './model/map_names';
import type { MapModel } from './model/map_model';
import { type Label, Labels } from './scene/labels';
import type { Painter } from './scene/painting';
import type { Stage } from './scene/stage';
import type { ViewState } from './view_state';

/** The names over the map: islands, and each robot at its newest keyframe. */
export class SceneLabels {
  private readonly global: Labels;
  private readonly local: Labels;

  constructor(private readonly stage: Stage, private readonly painter: Painter, private readonly names: MapNames) {
    this.global = new Labels(stage.globalPort);
    this.local = new Labels(stage.localPort);
  }

  update(model: MapModel, state: ViewState): void {
    const { hidden, layer } = state;
    if (layer !== 'local') this.global.update([...this.islands(model), ...this.robots(model, state)]);
    if (layer === 'global') return;
    this.local.update(this.stage.local.anchors().filter(({ agent }) => !hidden.has(agent)).map(({ id, agent, at }) => ({
      key: `island ${id}`, text: this.names.of(id), colour: this.painter.robotColour(agent), at,
    })));
  }

  /** Moves the camera on towards a robot's newest keyframe. */
  follow(robot: string): void {
    const at = this.newest(robot);
    if (at) this.stage.globalPort.follow(at);
  }

  private islands(model: MapModel): Label[] {
    if (model.islands().size < 2) return [];
    return [...model.islands()].flatMap(([name, members]) => {
      const box = this.stage.map.bounds(({ island }) => island === name);
      if (box.isEmpty()) return [];
      const owners = [...new Set(members.map(({ agent }) => agent))].join(', ');
      const text = `${name === model.globalIsland ? 'Reference island' : 'Island'} · ${members.length > 1 && owners ? owners : this.names.of(members[0]?.id ?? name)}`;
      const at = new Vector3((box.min.x + box.max.x) / 2, box.max.y, box.min.z);
      return [{ key: `island ${name}`, text, colour: this.painter.islandColour(name), at }];
    });
  }

  private robots(model: MapModel, state: ViewState): Label[] {
    return model.agents().filter((robot) => !state.hidden.has(robot)).flatMap((robot) => {
      const at = this.newest(robot);
      return at ? [{ key: `robot ${robot}`, text: robot, colour: this.painter.markColour(robot, state), at }] : [];
    });
  }

  private newest(robot: string): Vector3 | undefined {
    const views = [...this.stage.map.views.values()].filter(({ model }) => model.agent === robot && model.keyframes.count > 0);
    const last = views.sort((a, b) => a.model.number - b.model.number).at(-1)?.model;
    const index = last?.keyframes.newest();
    return last && index !== undefined ? this.stage.map.world({ localMap: last.id, index }) : undefined;
  }
}
