import { type ColourMode, type SceneColours, type Theme, categoryColour, mixed, sceneColours } from '../model/palette';
import type { LocalMapModel } from '../model/local_map';
import { byName, numberRobots } from '../model/robot_numbers';
import type { ViewState } from '../view_state';
import type { MapView } from './map_view';
import { type SharedUniforms, plainColour } from './materials';

/** Gives robots and islands their colours. */
export class Painter {
  islands: string[] = [];

  private names: string[] = [];
  private numbers = new Map<string, number>();

  constructor(public theme: Theme) {}

  /** All robots that were ever seen in the mission, by name. */
  get robots(): readonly string[] {
    return this.names;
  }

  addRobots(names: string[]): void {
    const known = new Set([...this.names, ...names]);
    if (known.size === this.names.length) return;
    this.names = [...known].sort(byName);
    this.numbers = numberRobots(this.names);
  }

  robotColour(robot: string): string {
    return categoryColour(this.theme, this.numbers.get(robot) ?? 0);
  }

  islandColour(island: string): string {
    return categoryColour(this.theme, Math.max(0, this.islands.indexOf(island)));
  }

  lineColour({ agent, island }: LocalMapModel, state: ViewState, colours: SceneColours): string {
    if (state.colour === 'island') return this.islandColour(island);
    if (state.colour === 'paper') return agent === (state.robot || this.names[0]) ? colours.own : colours.others;
    return this.robotColour(agent);
  }

  /** Of the mark at a robot's newest keyframe. */
  markColour(robot: string, state: ViewState): string {
    if (state.colour !== 'paper') return this.robotColour(robot);
    const { own, others } = sceneColours(this.theme);
    return robot === (state.robot || this.names[0]) ? own : others;
  }

  /** As the list of robots shows it: what the map draws it in. */
  legendColour(robot: string, state: ViewState, islands: string[]): string {
    if (state.colour === 'island' && islands.length > 0) return this.islandColour(islands.at(-1)!);
    return this.markColour(robot, state);
  }

  pointColour(localMap: LocalMapModel, state: ViewState, colours: SceneColours): string {
    if (state.colour === 'paper') return colours.ink;
    return mixed(this.lineColour(localMap, state, colours), colours.ink, 0.25);
  }
}

const RAMPS: Record<ColourMode, number> = { robot: 0, island: 0, paper: 0, height: 1, age: 2, observations: 3 };

export function paintMap(
  map: MapView, uniforms: SharedUniforms, state: ViewState, painter: Painter, colours: SceneColours,
): void {
  uniforms.ramp.value = RAMPS[state.colour];
  [uniforms.rampLow, uniforms.rampMiddle, uniforms.rampHigh].forEach(({ value }, i) => plainColour(value, colours.ramp[i]));
  const box = map.bounds(() => true);
  const margin = 3 + 0.1 * (box.max.y - box.min.y);
  if (!box.isEmpty()) uniforms.heights.value.set(box.min.y - margin, box.max.y + 2 * margin);
  for (const view of map.views.values()) {
    const isVisible = !state.hidden.has(view.model.agent);
    view.group.visible = isVisible;
    const lines = painter.lineColour(view.model, state, colours);
    view.paint(painter.pointColour(view.model, state, colours), lines, state);
    const isDim = state.robot !== '' && state.robot !== view.model.agent && state.colour !== 'paper';
    view.keyframes.path.lines.material.uniforms.opacity.value = isDim ? 0.45 : 1;
    view.keyframes.path.lines.material.uniforms.widthPx.value = isDim ? 2 : 3;
  }
}
