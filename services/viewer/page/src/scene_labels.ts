import { Vector3 } from 'three';
import type { Doing } from './model/activity';
import type { MapNames } from './model/map_names';
import type { MapModel } from './model/map_model';
import { type Label, Labels } from './scene/labels';
import type { Painter } from './scene/painting';
import type { Stage } from './scene/stage';
import type { ViewState } from './view_state';

/** What is known of a robot at this moment. */
export interface RobotNow {
  doing: Doing;
  /** Where it said itself that it is, if that is how it is known; in the picture. */
  at: Vector3 | undefined;
}

/** What a label says beside the name, where that is worth a word. */
const SAID: Partial<Record<Doing, string>> = { lost: 'lost', standing: 'no frames', finished: 'finished', gone: 'away' };

/** The names over the map: islands, and each robot at its newest keyframe. */
export class SceneLabels {
  private readonly global: Labels;
  private readonly local: Labels;

  constructor(
    private readonly stage: Stage, private readonly painter: Painter, private readonly names: MapNames,
    private readonly now: (robot: string) => RobotNow,
  ) {
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
    const robots = new Set([...model.agents(), ...this.painter.robots]);
    return [...robots].filter((robot) => !state.hidden.has(robot)).flatMap((robot) => {
      const at = this.newest(robot);
      const { doing } = this.now(robot);
      const text = SAID[doing] ? `${robot} · ${SAID[doing]}` : robot;
      return at ? [{ key: `robot ${robot}`, text, colour: this.painter.markColour(robot, state), at, doing }] : [];
    });
  }

  /** Where a robot is: where it said itself, or its newest keyframe. */
  newest(robot: string): Vector3 | undefined {
    const { at } = this.now(robot);
    if (at) return at;
    const views = [...this.stage.map.views.values()].filter(({ model }) => model.agent === robot && model.keyframes.count > 0);
    const last = views.sort((a, b) => a.model.number - b.model.number).at(-1)?.model;
    const index = last?.keyframes.newest();
    return last && index !== undefined ? this.stage.map.world({ localMap: last.id, index }) : undefined;
  }
}
