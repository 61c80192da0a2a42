import type { ColourMode } from './model/palette';
import type { Layer, ViewState } from './view_state';
import type { Offer } from './feed/rest';
import { currentTheme } from './panels/toolbar';

/** What keys ask of the page. */
export interface KeyActions {
  change(part: Partial<ViewState>): void;
  selectRobot(number: number): void;
  fit(): void;
  play(): void;
  step(by: number): boolean;
  escape(): void;
  help(): void;
  measure(): void;
  find(): void;
}

const COLOURS: ColourMode[] = ['robot', 'island', 'paper', 'height', 'age', 'observations'];
const LAYERS: Layer[] = ['global', 'local', 'both'];
const TOGGLES = {
  p: 'points', k: 'keyframes', j: 'paths', e: 'frames', o: 'overlaps', r: 'refused', t: 'top', g: 'follow',
} as const;

/** Keys of what only a server can tell, and of what only a past can. */
const NEEDS_SERVER = /^[ev]$/;
const NEEDS_PAST = ' ';

/** Handles a key; returns whether it meant something. */
export function handleKey(event: KeyboardEvent, state: ViewState, actions: KeyActions, offer: Offer): boolean {
  // An enlarged picture has the keys: Escape closes it alone.
  if (document.querySelector('dialog.enlarged[open]')) return false;
  if (event.ctrlKey || event.altKey || event.metaKey || isTyping(event)) return false;
  const key = event.key.toLowerCase();
  if ((!offer.isServed && NEEDS_SERVER.test(key)) || (!offer.hasPast && key === NEEDS_PAST)) return false;
  if (key in TOGGLES) {
    const name = TOGGLES[key as keyof typeof TOGGLES];
    actions.change({ [name]: !state[name] });
  } else if (/^[1-9]$/.test(key)) actions.selectRobot(Number(key) - 1);
  else if (key === 'f') actions.fit();
  else if (key === 'c') actions.change({ colour: after(COLOURS, state.colour) });
  else if (key === 'v') actions.change({ layer: after(LAYERS, state.layer) });
  else if (key === 'l') actions.change({ theme: currentTheme() === 'dark' ? 'light' : 'dark' });
  else if (key === ' ' && !isButton(event)) actions.play();
  else if (key === 'arrowleft' || key === 'arrowright') return actions.step(key === 'arrowleft' ? -1 : 1);
  else if (key === 'escape') actions.escape();
  else if (key === '?') actions.help();
  else if (key === 'm') actions.measure();
  else if (key === '/') actions.find();
  else return false;
  return true;
}

function after<T>(all: T[], one: T): T {
  return all[(all.indexOf(one) + 1) % all.length];
}

function isTyping({ target }: KeyboardEvent): boolean {
  // Letters and arrows choose in a list.
  if (target instanceof HTMLSelectElement) return true;
  return target instanceof HTMLInputElement && target.type !== 'checkbox' && target.type !== 'range';
}

function isButton({ target }: KeyboardEvent): boolean {
  return target instanceof HTMLElement && /^(BUTTON|SELECT|INPUT|A)$/.test(target.tagName);
}
