import type { Offer } from '../feed/rest';
import { h, table } from './dom';

const KEYS: [string, string][] = [
  ['1 … 9', 'Select a robot; again: none'], ['G', 'Follow the selected robot'], ['F', 'Show all'],
  ['T', 'From above, as the paper’s figures'], ['P', 'Points'], ['K', 'Keyframes'], ['J', 'Paths'],
  ['E', 'Every frame’s place'], ['O', 'Accepted overlaps'], ['R', 'Refused overlaps'],
  ['C', 'Next colouring'], ['M', 'Measure: how far two keyframes or points are apart'], ['/', 'Find a robot, keyframe, local map or overlap'],
  ['V', 'Global layer, local layer, side by side'], ['L', 'Light or dark'],
  ['Space', 'Play or pause the history'], ['← →', 'Step through the history, or move the map'],
  ['Esc', 'Close; back to live'], ['?', 'This help'],
];
const MOUSE: [string, string][] = [
  ['Drag', 'Turn (one finger)'], ['Right drag', 'Move (two fingers)'], ['Wheel', 'Nearer or farther (pinch)'],
  ['Click', 'A keyframe or an overlap’s line: what is it, and why?'],
];
const EVENT: [string, string] = ['Click', 'An event: the map as it was then'];

/** Rows of what only a server can tell, and of what only a past can. */
const NEEDS_SERVER: readonly string[] = ['E', 'V'];
const NEEDS_PAST: readonly string[] = ['Space'];

export function helpDialog(offer: Offer): HTMLDialogElement {
  const keys = KEYS.filter(([key]) => (offer.isServed || !NEEDS_SERVER.includes(key)) && (offer.hasPast || !NEEDS_PAST.includes(key)));
  const dialog: HTMLDialogElement = h('dialog', { class: 'help', 'aria-labelledby': 'help-title' },
    h('h2', { id: 'help-title' }, 'Keys and mouse'), table(keys), h('hr'), table(offer.isServed ? [...MOUSE, EVENT] : MOUSE),
    h('form', { method: 'dialog' }, h('button', { autofocus: true }, 'Close')));
  return dialog;
}
