import type { Mission } from '@gen/corbslam/v1/resources_pb';
import { lastSegment } from '../model/ids';
import { count } from '../model/words';
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

  private row(mission: Mission): HTMLElement {
    const name = lastSegment(mission.name);
    const words = `${count(mission.agents)} robots · ${count(mission.islands)} islands · ${count(mission.keyframes)} keyframes · ${count(mission.mapPoints)} points`;
    return h('li', {}, h('button', { click: () => this.open(name) }, h('strong', {}, name), h('span', {}, words)));
  }

  private show(title: string, ...children: Node[]): void {
    this.root.replaceChildren(h('h1', {}, 'CORB-SLAM map viewer'), h('h2', {}, title), ...children);
  }
}
