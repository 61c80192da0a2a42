import type { Mission } from '@gen/corbslam/v1/resources_pb';
import { lastSegment } from '../model/ids';
import { byName } from '../model/robot_numbers';
import { many, since, timeOfDay } from '../model/texts';
import { h } from './dom';

/** The start screen: the missions, or a question for the token. */
export class StartScreen {
  readonly root = h('main', { class: 'start' });
  private shown: string | undefined;

  /** `isServed`: a server has missions to choose from. */
  constructor(
    private readonly open: (mission: string) => void, private readonly giveToken: (token: string) => void, private readonly isServed: boolean,
  ) {}

  missions(missions: Mission[]): void {
    // What stays as it was keeps the focus.
    const key = missions.map((mission) => [mission.name, nowText(mission), sizeText(mission), mission.description].join()).join(';');
    if (this.shown === key && this.root.isConnected) return;
    this.show('Missions', missions.length === 0
      ? h('p', { class: 'quiet' }, 'No mission yet. One begins with its first robot; this list looks again by itself.')
      : h('ul', { class: 'missions' }, ...[...missions].sort(byUse).map((mission) => this.row(mission))));
    this.shown = key;
  }

  askToken(reason: string): void {
    const input = h('input', { type: 'password', name: 'token', autocomplete: 'off', required: true, id: 'token' });
    const submit = (event: Event) => {
      event.preventDefault();
      this.giveToken(input.value.trim());
    };
    this.show('A token is needed', h('form', { submit },
      h('p', { role: 'alert' }, reason), h('label', { for: 'token' }, 'Token'), input, h('button', {}, 'Go on'),
      h('a', { href: '#' }, 'All missions')));
    input.focus();
  }

  fail(reason: string): void {
    this.show('The viewer does not answer', h('p', { role: 'alert' }, reason), h('p', { class: 'quiet' }, 'It is asked again in a moment.'));
  }

  /** This browser can't draw. */
  cannotDraw(reason: string): void {
    this.show('This browser can’t draw the map', h('p', { role: 'alert' }, reason),
      h('p', {}, 'Maps are drawn with WebGL 2. It may be off in the browser’s settings, or missing with this graphics card or remote desktop.'),
      h('p', {}, this.isServed ? h('a', { href: '#' }, 'All missions') : 'map.png beside the report shows it from above.'));
  }

  private row(mission: Mission): HTMLElement {
    const name = lastSegment(mission.name);
    return h('li', {}, h('button', { click: () => this.open(name), 'data-focus': `mission-${name}` }, h('strong', {}, name),
      h('span', { class: mission.connectedAgents > 0 ? 'now' : '' }, nowText(mission)), h('span', {}, sizeText(mission)),
      mission.description ? h('span', { class: 'description' }, mission.description) : ''));
  }

  private show(title: string, ...children: Node[]): void {
    this.shown = undefined;
    const focused = document.activeElement instanceof HTMLElement ? document.activeElement.dataset.focus : undefined;
    this.root.replaceChildren(h('h1', {}, 'CORB-SLAM map viewer'), h('h2', {}, title), ...children);
    if (focused) this.root.querySelector<HTMLElement>(`[data-focus="${CSS.escape(focused)}"]`)?.focus();
  }
}

/** Who drives now, and when it began and was last used. */
export function nowText(mission: Mission, nowMs = Date.now()): string {
  const { connectedAgents, createdNs, lastUsedNs } = mission;
  const begun = createdNs > 0n ? [`begun ${timeOfDay(createdNs, nowMs)}`] : [];
  if (connectedAgents > 0) return [`${many(connectedAgents, 'robot')} connected now`, ...begun].join(' · ');
  const used = lastUsedNs > 0n ? [`last used ${since(lastUsedNs, BigInt(nowMs) * 1_000_000n)} ago`] : [];
  return [...used, ...begun].join(' · ');
}

function sizeText(mission: Mission): string {
  return [
    many(mission.agents, 'robot'), many(mission.islands, 'island'), many(mission.keyframes, 'keyframe'), many(mission.mapPoints, 'point'),
    ...(mission.asleep ? ['asleep'] : []), ...(mission.damage ? ['its journal is damaged'] : []),
  ].join(' · ');
}

/** Those that robots drive in come first, then those that were used last. */
export function byUse(a: Mission, b: Mission): number {
  if ((a.connectedAgents > 0) !== (b.connectedAgents > 0)) return a.connectedAgents > 0 ? -1 : 1;
  if (a.lastUsedNs !== b.lastUsedNs) return a.lastUsedNs > b.lastUsedNs ? -1 : 1;
  return byName(a.name, b.name);
}
