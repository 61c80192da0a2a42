import type { ColourMode } from '../model/palette';
import type { Offer } from '../feed/rest';
import { type Layer, SIZES, type ViewState } from '../view_state';
import { h, setText } from './dom';

type Toggle = 'points' | 'keyframes' | 'paths' | 'frames' | 'overlaps' | 'refused';

/** What the tools ask of the page. */
export interface ToolActions {
  change(part: Partial<ViewState>): void;
  fit(): void;
  history(): void;
  help(): void;
  measure(): void;
}

const TOGGLES: [Toggle, string, string][] = [
  ['points', 'Points', 'P'], ['keyframes', 'Keyframes', 'K'], ['paths', 'Paths', 'J'],
  ['frames', 'Every frame', 'E'], ['overlaps', 'Overlaps', 'O'], ['refused', 'Refused', 'R'],
];
/** What a server is asked for once it is to be seen. */
const ASKED_FOR: ReadonlySet<Toggle> = new Set(['frames']);
const COLOURS: [ColourMode, string][] = [
  ['robot', 'Robot'], ['island', 'Island'], ['paper', 'Own / others'], ['height', 'Height'], ['age', 'Age'],
  ['observations', 'Observations'],
];
const POINT_SIZES: [string, string][] = SIZES.map((size) => [String(size), `${size} px`]);
const LAYERS: [Layer, string][] = [['global', 'Global'], ['local', 'Local'], ['both', 'Side by side']];

/** The tools over the map. */
export class Toolbar {
  readonly root: HTMLElement;
  private readonly toggles = new Map<keyof ViewState, HTMLButtonElement>();
  private readonly measure: HTMLButtonElement;
  private readonly selects = new Map<keyof ViewState, HTMLSelectElement>();

  constructor(private readonly actions: ToolActions, { isServed, hasPast }: Offer) {
    const { change, fit, history, help, measure } = actions;
    this.root = h('div', { class: 'toolbar', role: 'toolbar', 'aria-label': 'What is shown' },
      h('div', { class: 'group' }, ...TOGGLES.filter(([name]) => isServed || !ASKED_FOR.has(name)).map(([name, words, key]) => this.toggle(name, words, key))),
      h('div', { class: 'group' }, this.select('colour', 'Colour', COLOURS), ...(isServed ? [this.select('layer', 'Layer', LAYERS)] : []), this.select('size', 'Point', POINT_SIZES)),
      h('div', { class: 'group' },
        button('Fit', 'Show all (F)', fit), this.toggle('top', 'Top', 'T'), this.toggle('follow', 'Follow', 'G'),
        this.measure = button('Measure', 'How far two keyframes or points are apart (M)', measure),
        hasPast && button('History', 'Play the past (space)', history),
        button('◐', 'Light or dark (L)', () => change({ theme: currentTheme() === 'dark' ? 'light' : 'dark' }), 'Light or dark'),
        button('?', 'Keys (?)', help, 'Help')));
  }

  update(state: ViewState): void {
    for (const [name, element] of this.toggles) element.setAttribute('aria-pressed', String(state[name]));
    for (const [name, element] of this.selects) element.value = String(state[name]);
  }

  /** Whether clicks measure. */
  noteMeasure(isOn: boolean): void {
    this.measure.setAttribute('aria-pressed', String(isOn));
  }

  /** Says in the choice whether the store tells how many keyframes see a point. */
  noteObservations(isTold: boolean): void {
    const option = this.selects.get('colour')!.querySelector<HTMLElement>('[value="observations"]')!;
    setText(option, isTold ? 'Observations' : 'Observations (not told)');
  }

  private toggle(name: Toggle | 'top' | 'follow', words: string, key: string): HTMLElement {
    const flip = () => this.actions.change({ [name]: this.toggles.get(name)!.getAttribute('aria-pressed') !== 'true' });
    const element = button(words, `${words} (${key})`, flip);
    this.toggles.set(name, element);
    return element;
  }

  private select(name: 'colour' | 'layer' | 'size', words: string, options: [string, string][]): HTMLElement {
    const element = h('select', {}, ...options.map(([value, text]) => h('option', { value }, text)));
    element.addEventListener('change', () => this.actions.change({ [name]: name === 'size' ? Number(element.value) : element.value }));
    this.selects.set(name, element);
    return h('label', {}, h('span', {}, words), element);
  }
}

export function currentTheme(): 'light' | 'dark' {
  return document.documentElement.dataset.theme === 'dark' ? 'dark' : 'light';
}

function button(words: string, title: string, click: () => void, label?: string): HTMLButtonElement {
  return h('button', { type: 'button', title, click, 'aria-label': label }, words);
}
