import type { MissionPulse } from '@gen/corbslam/v1/viewer_pb';
import type { AgentStatus } from '@gen/corbslam/v1/agent_service_pb';
import type { LocalMap, MissionAgent } from '@gen/corbslam/v1/resources_pb';
import { contradictionFacts, type Doing, doingOf, reportFacts } from '../model/activity';
import { lastSegment } from '../model/ids';
import type { MapModel } from '../model/map_model';
import type { MapNames } from '../model/map_names';
import { plainText } from '../model/plain_text';
import { bytes, count, many, trackingText } from '../model/texts';
import type { ViewState } from '../view_state';
import { h, panel, refill, swatch, table } from './dom';

/** Of AgentStatus.outboxCode. */
const RESOURCE_EXHAUSTED = 8;

/** What the panel asks of the page. */
export interface RobotActions {
  toggle(robot: string): void;
  select(robot: string): void;
  colour(robot: string): string;
  /** What fusion has moved it by, in words. */
  drift(robot: string): string;
  /** It has runs that made no map. */
  hasLocalised(robot: string): boolean;
}

/** The legend of the robots, and how each is doing. */
export class RobotsPanel {
  readonly root: HTMLElement;
  private readonly body: HTMLElement;
  /** By robot: since when it is away, as far as that was told or seen. */
  private readonly awaySince = new Map<string, bigint>();
  private readonly wasConnected = new Set<string>();

  constructor(private readonly actions: RobotActions, private readonly names: MapNames) {
    ({ root: this.root, body: this.body } = panel('robots', 'Robots'));
  }

  /** `isLive`: what the pulse says is how things are now; `isPast`: the map is one of the past. */
  update(robots: readonly string[], model: MapModel, pulse: MissionPulse | undefined, state: ViewState, now: { isLive: boolean; isPast: boolean }): void {
    if (now.isLive) this.noteAbsences(pulse);
    const rows = robots.map((robot) => this.facts(robot, model, now.isLive ? pulse : undefined, now.isPast));
    const key = JSON.stringify([rows, state.robot, [...state.hidden], robots.map((r) => this.actions.colour(r))]);
    refill(this.body, key, () => {
      if (robots.length === 0) return [h('p', { class: 'quiet' }, 'No robot has sent anything yet.')];
      return robots.map((robot, i) => this.row(robot, i, rows[i], state));
    });
  }

  /** Somebody may read it. */
  get isShown(): boolean {
    return this.root.offsetParent !== null && !document.hidden;
  }

  /** When an agent left, as an event says. */
  noteLeft(robot: string, timeNs: bigint): void {
    this.awaySince.set(robot, timeNs);
  }

  private noteAbsences(pulse: MissionPulse | undefined): void {
    for (const { name, connected } of pulse?.agents ?? []) {
      const robot = lastSegment(name);
      if (connected) {
        this.awaySince.delete(robot);
        this.wasConnected.add(robot);
      } else if (!this.awaySince.has(robot) && this.wasConnected.has(robot)) this.awaySince.set(robot, pulse!.timeNs);
    }
  }

  private row(robot: string, i: number, facts: [string, string][], { robot: selected, hidden }: ViewState): HTMLElement {
    const { toggle, select, colour } = this.actions;
    const box = h('input', {
      type: 'checkbox', 'aria-label': `Show ${robot}`, 'data-focus': `show-${robot}`, change: () => toggle(robot),
    });
    box.checked = !hidden.has(robot);
    const isSelected = selected === robot;
    const name = h('button', {
      class: 'robot-name', 'aria-pressed': String(isSelected), 'data-focus': `robot-${robot}`,
      title: i < 9 ? `Select (key ${i + 1})` : 'Select', click: () => select(isSelected ? '' : robot),
    }, swatch(colour(robot)), robot);
    const [status, ...rest] = facts;
    const connection = h('span', { class: `chip ${status[0]}`, 'data-doing': status[0] }, status[1]);
    return h('div', { class: 'robot-row' }, h('div', { class: 'robot-head' }, box, name, connection), table(rest));
  }

  private facts(robot: string, model: MapModel, pulse: MissionPulse | undefined, isPast: boolean): [string, string][] {
    const agent = pulse?.agents.find(({ name }) => lastSegment(name) === robot);
    const rows: [string, string][] = [this.connection(robot, agent, pulse)];
    const isBare = agent?.localMaps.length === 0 && this.actions.hasLocalised(robot);
    if (agent?.localiseOnly || isBare) rows.push(['Role', 'only localises, maps nothing']);
    else rows.push(...this.mapFacts(robot, model, pulse, agent, isPast));
    if (agent?.connected && !agent.localiseOnly) rows.push(['Shared map', agent.upToDate ? 'up to date' : 'waits for updates']);
    if (agent) rows.push(...contradictionFacts(agent, this.names));
    const told = pulse?.robots.find((one) => lastSegment(one.agent) === robot);
    if (told?.status) return [...rows, ...statusFacts(told.status)];
    if (agent) rows.push(...reportFacts(agent));
    if (agent?.connected && !agent.report && agent.lastPose) rows.push(['Last pose', agent.lastPose.lostSince ? 'later frames were lost' : 'of the newest frame that was told']);
    if (told?.error) rows.push(['Asked itself', `does not answer: ${plainText(told.error)}`]);
    return rows;
  }

  private mapFacts(robot: string, model: MapModel, pulse: MissionPulse | undefined, agent: MissionAgent | undefined, isPast: boolean): [string, string][] {
    const maps = pulse?.localMaps.filter((map) => lastSegment(map.agent) === robot) ?? [];
    const own = [...model.localMaps.values()].filter((map) => map.agent === robot);
    const keyframes = own.reduce((sum, map) => sum + map.keyframes.count, 0);
    const sum = (of: (map: LocalMap) => bigint) => maps.reduce((all, map) => all + of(map), 0n);
    const then = isPast ? ' then' : '';
    const rows: [string, string][] = [];
    rows.push([`Local maps${then}`, String(isPast ? own.length : Math.max(own.length, agent?.localMaps.length ?? 0))]);
    rows.push([`Keyframes${then}`, count(keyframes)]);
    const [retired, faded, lost] = [sum((map) => map.retiredKeyframes), sum((map) => map.fadedMapPoints), sum((map) => map.lostFrames)];
    if (retired > 0n) rows.push(['… let go of since', `${count(retired)}: others see the same`]);
    if (faded > 0n) rows.push(['Points let go of', `${count(faded)}: not seen again`]);
    const drift = this.actions.drift(robot);
    if (drift) rows.push([isPast ? 'Moved by fusion now' : 'Moved by fusion', drift]);
    if (lost > 0n) rows.push(['Lost frames', count(lost)]);
    return rows;
  }

  /** What a robot is doing, by name; for its mark in the map. */
  doing(robot: string, pulse: MissionPulse | undefined): Doing {
    return doingOf(pulse?.agents.find(({ name }) => lastSegment(name) === robot)).doing;
  }

  private connection(robot: string, agent: MissionAgent | undefined, pulse: MissionPulse | undefined): [string, string] {
    const from = this.awaySince.get(robot);
    const awayS = from && pulse ? Number((pulse.timeNs - from) / 1_000_000n) / 1000 : undefined;
    const { doing, words } = doingOf(agent, awayS);
    return [doing, words];
  }
}

/** What a robot says of itself. */
export function statusFacts(status: AgentStatus): [string, string][] {
  const rows: [string, string][] = [['Tracking', trackingText(status)]];
  if (status.mappingPaused) rows.push(['Mapping', 'paused']);
  if (status.dropped > 0n) rows.push(['Frames passed over', `${count(status.dropped)}, they came too fast`]);
  if (status.outboxBatches > 0n) {
    const size = bytes(status.outboxMemoryBytes + status.outboxSpoolBytes);
    rows.push(['Waits to be sent', `${count(status.outboxBatches)} ${status.outboxBatches === 1n ? 'batch' : 'batches'}, ${size}`]);
  }
  if (status.outboxCode === RESOURCE_EXHAUSTED) rows.push(['Room for it', 'none: changes wait in the map']);
  else if (status.outboxCode !== 0) rows.push(['Room for it', 'its disk fails']);
  if (status.lostLocalMaps > 0) rows.push(['Could not go on', many(status.lostLocalMaps, 'local map')]);
  if (status.sessionMessage) rows.push(['Link', plainText(status.sessionMessage)]);
  return rows;
}
