import { h, setText } from './panels/dom';

const TABS: [string, string][] = [
  ['robots', 'Robots'], ['numbers', 'Numbers'], ['overlaps', 'Overlaps'], ['events', 'Events'], ['details', 'Selected'],
];

/** The elements into which a mission's page is put. */
export class FrameLayout {
  readonly canvas = h('canvas', { class: 'scene', role: 'img', 'aria-label': 'The map' });
  readonly globalPort = h('div', { class: 'port', tabindex: '0', 'aria-label': 'Global layer: drag to turn, arrows to move', role: 'application' });
  readonly localPort = h('div', { class: 'port', tabindex: '0', 'aria-label': 'Local layer', role: 'application' });
  readonly banner = h('div', { class: 'banner', role: 'status', 'aria-live': 'polite' });
  readonly connection = h('span', { class: 'chip' });
  readonly left = h('aside', { class: 'side left', 'aria-label': 'Robots and numbers' });
  readonly right = h('aside', { class: 'side right', 'aria-label': 'Selected, overlaps and events' });
  readonly below = h('div', { class: 'below' });
  readonly root: HTMLElement;

  /** `isServed`: a server has other missions, too. */
  constructor(mission: string, toolbar: HTMLElement, isServed = true) {
    const back = h('a', { href: '#', class: 'back', title: 'All missions' }, '‹ Missions');
    const tabs = h('nav', { class: 'tabs', 'aria-label': 'Panels' }, ...TABS.filter(([id]) => isServed || id !== 'events').map(([id, words]) => this.tab(id, words)));
    const sides = h('div', { class: 'sides' }, tabs, this.left, this.right);
    this.banner.hidden = true;
    this.root = h('div', { class: 'page' },
      h('header', {}, ...(isServed ? [back] : []), h('h1', { title: mission }, h('bdi', {}, mission)), this.connection),
      h('main', { class: 'map' }, this.canvas, h('div', { class: 'ports' }, this.globalPort, this.localPort),
        h('div', { class: 'above' }, toolbar, this.banner), this.below),
      sides);
    this.showTab('robots');
  }

  showTab(id: string): void {
    this.root.dataset.tab = id;
    for (const tab of this.root.querySelectorAll<HTMLElement>('.tabs button')) {
      tab.setAttribute('aria-pressed', String(tab.dataset.tab === id));
    }
  }

  /** What those hear who don't see the picture. */
  describe(words: string): void {
    if (this.canvas.getAttribute('aria-label') !== words) this.canvas.setAttribute('aria-label', words);
  }

  showBanner(words: string): void {
    this.banner.hidden = words === '';
    setText(this.banner, words);
  }

  showConnection(isLive: boolean, words: string): void {
    this.connection.className = `chip ${isLive ? 'online' : words === 'the past' || words === 'recorded' ? 'past' : 'offline'}`;
    setText(this.connection, words);
  }

  private tab(id: string, words: string): HTMLElement {
    return h('button', { type: 'button', 'data-tab': id, click: () => this.showTab(id) }, words);
  }
}
