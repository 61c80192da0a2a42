import type { Mission } from '@gen/corbslam/v1/resources_pb';
import { lastSegment } from '../model/ids';
import { many } from '../model/words';
import { h } from './dom';

/** The start screen: the missions, or a question for the token. */
export class StartScreen {
  readonly root = h('main', { class: 'start' });

  constructor(private readonly open: (mission: string) => void, private readonly giveToken: (token: string) => void) {}

  missions(missions: Mission[]): void {
    this.show('Missions', missions.length === 0
      ? h('p', { class: 'quiet' }, 'No mission yet. One begins with its first robot; this list looks again by itself.')
      : h('ul', { class: 'missions' }, ...missions.map((mission) => this.row(mission))));
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
      h('p', {}, h('a', { href: '#' }, 'All missions')));
  }

  private row(mission: Mission): HTMLElement {
    const name = lastSegment(mission.name);
    const words = [
      many(mission.agents, 'robot'), many(mission.islands, 'island'), many(mission.keyframes, 'keyframe'), many(mission.mapPoints, 'point'),
      ...(mission.asleep ? ['asleep'] : []), ...(mission.damage ? ['its journal is damaged'] : []),
    ].join(' · ');
    return h('li', {}, h('button', { click: () => this.open(name) }, h('strong', {}, name), h('span', {}, words)));
  }

  private show(title: string, ...children: Node[]): void {
    this.root.replaceChildren(h('h1', {}, 'CORB-SLAM map viewer'), h('h2', {}, title), ...children);
  }
}
