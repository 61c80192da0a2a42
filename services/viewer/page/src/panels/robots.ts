import type { MissionPulse } from '@gen/corbslam/v1/viewer_pb';
import type { AgentStatus } from '@gen/corbslam/v1/agent_service_pb';
import { lastSegment } from '../model/ids';
import type { MapModel } from '../model/map_model';
import { bytes, count, since, trackingWords } from '../model/words';
import type { ViewState } from '../view_state';
import { h, panel, refill, swatch, table } from './dom';

/** What the panel asks of the page. */
export interface RobotActions {
  toggle(robot: string): void;
  select(robot: string): void;
  colour(robot: string): string;
}

/** The legend of the robots, and how each is doing. */
export class RobotsPanel {
  readonly root: HTMLElement;
  private readonly body: HTMLElement;
  /** By robot: since when it is away, by the viewer's clock. */
  private readonly awaySince = new Map<string, bigint>();

  constructor(private readonly actions: RobotActions) {
    ({ root: this.root, body: this.body } = panel('robots', 'Robots'));
  }

  update(robots: readonly string[], model: MapModel, pulse: MissionPulse | undefined, state: ViewState): void {
    this.noteAbsences(pulse);
    const rows = robots.map((robot) => this.facts(robot, model, pulse));
    const key = JSON.stringify([rows, state.robot, [...state.hidden], robots.map((r) => this.actions.colour(r))]);
    refill(this.body, key, () => {
      if (robots.length === 0) return [h('p', { class: 'quiet' }, 'No robot has sent anything yet.')];
      return robots.map((robot, i) => this.row(robot, i, rows[i], state));
    });
  }

  /** When an agent left, as an event says. */
  noteLeft(robot: string, timeNs: bigint): void {
    this.awaySince.set(robot, timeNs);
  }

  private noteAbsences(pulse: MissionPulse | undefined): void {
    for (const { name, connected } of pulse?.agents ?? []) {
      const robot = lastSegment(name);
      if (connected) this.awaySince.delete(robot);
      else if (!this.awaySince.has(robot)) this.awaySince.set(robot, pulse!.timeNs);
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
    const connection = h('span', { class: `chip ${status[0]}` }, status[1]);
    return h('div', { class: 'robot-row' }, h('div', { class: 'robot-head' }, box, name, connection), table(rest));
  }

  private facts(robot: string, model: MapModel, pulse: MissionPulse | undefined): [string, string][] {
    const agent = pulse?.agents.find(({ name }) => lastSegment(name) === robot);
    const maps = pulse?.localMaps.filter((map) => lastSegment(map.agent) === robot) ?? [];
    const own = [...model.localMaps.values()].filter((map) => map.agent === robot);
    const keyframes = own.reduce((sum, map) => sum + map.keyframes.count, 0);
    const lost = maps.reduce((sum, map) => sum + Number(map.lostFrames), 0);
    const rows: [string, string][] = [this.connection(robot, agent?.connected, pulse)];
    rows.push(['Local maps', String(Math.max(own.length, agent?.localMaps.length ?? 0))]);
    rows.push(['Keyframes', count(keyframes)]);
    if (lost > 0) rows.push(['Lost frames', count(lost)]);
    if (agent?.connected) rows.push(['Shared map', agent.upToDate ? 'up to date' : 'waits for updates']);
    const told = pulse?.robots.find((one) => lastSegment(one.agent) === robot);
    return [...rows, ...(told?.status ? statusFacts(told.status) : told?.error ? [['Robot', told.error] as [string, string]] : [])];
  }

  private connection(robot: string, connected: boolean | undefined, pulse: MissionPulse | undefined): [string, string] {
    if (connected === undefined) return ['unknown', 'not known'];
    if (connected) return ['online', 'connected'];
    const from = this.awaySince.get(robot);
    return ['offline', from && pulse ? `offline ${since(from, pulse.timeNs)}` : 'offline'];
  }
}

function statusFacts(status: AgentStatus): [string, string][] {
  const rows: [string, string][] = [['Tracking', trackingWords(status.state)]];
  if (status.outboxBatches > 0n) {
    const size = bytes(status.outboxMemoryBytes + status.outboxSpoolBytes);
    rows.push(['Waits to be sent', `${count(status.outboxBatches)} batches, ${size}`]);
  }
  if (status.sessionMessage) rows.push(['Link', status.sessionMessage]);
  return rows;
}
