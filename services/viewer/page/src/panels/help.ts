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
  ['Click', 'An event: the map as it was then'],
  ['Click', 'A keyframe or an overlap’s line: what is it, and why?'],
];

export function helpDialog(): HTMLDialogElement {
  const dialog: HTMLDialogElement = h('dialog', { class: 'help', 'aria-labelledby': 'help-title' },
    h('h2', { id: 'help-title' }, 'Keys and mouse'), table(KEYS), h('hr'), table(MOUSE),
    h('form', { method: 'dialog' }, h('button', { autofocus: true }, 'Close')));
  return dialog;
}
