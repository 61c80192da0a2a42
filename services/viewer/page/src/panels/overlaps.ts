import type { Overlap } from '@gen/corbslam/v1/overlap_pb';
import { MOST_OVERLAPS } from '../feed/rest';
import { decidingText, stageRows } from '../model/refusal';
import { count, isAccepted, verdictText } from '../model/texts';
import { h, panel, refill, table } from './dom';

const MOST_ROWS = 150;

/** The overlaps of the mission; a click says why one was accepted or refused. */
export class OverlapsPanel {
  readonly root: HTMLElement;
  private readonly body: HTMLElement;
  private chosen: bigint | undefined;
  private wasRefused = false;

  constructor(private readonly choose: (overlap: Overlap) => void) {
    ({ root: this.root, body: this.body } = panel('overlaps', 'Overlaps'));
  }

  update(overlaps: Overlap[], showsRefused: boolean, chosen: Overlap | undefined,
    side: (name: string) => string, said: { note: string; version: number }): void {
    const shown = overlaps.filter((overlap) => showsRefused || isAccepted(overlap)).reverse();
    const accepted = overlaps.filter(isAccepted).length;
    const key = [shown.length, shown[0]?.number, accepted, chosen?.number, showsRefused, said.note, said.version].join();
    // New rows would move the others away from under the pointer.
    if (this.body.matches(':hover') && this.chosen === chosen?.number && this.wasRefused === showsRefused) return;
    const { note } = said;
    this.chosen = chosen?.number;
    this.wasRefused = showsRefused;
    refill(this.body, key, () => [
      h('p', { class: 'quiet' }, this.summary(overlaps.length, accepted, showsRefused)),
      note !== '' && h('p', { class: 'quiet' }, note),
      shown.length > MOST_ROWS && h('p', { class: 'quiet' }, `The newest ${MOST_ROWS} are listed; each has its line in the map.`),
      h('ul', { class: 'overlaps' }, ...shown.slice(0, MOST_ROWS).map((overlap) => this.row(overlap, chosen, side))),
    ].filter((node) => node !== false));
  }

  private summary(all: number, accepted: number, showsRefused: boolean): string {
    const rest = showsRefused ? `, ${count(all - accepted)} refused` : '; press R for refused ones';
    return `${count(accepted)} accepted${rest}`;
  }

  private row(overlap: Overlap, chosen: Overlap | undefined, side: (name: string) => string): HTMLElement {
    const mark = isAccepted(overlap) ? 'yes' : 'no';
    const sides = `${side(overlap.query)} – ${side(overlap.candidate)}`;
    return h('li', {}, h('button', {
      class: `overlap ${mark}`, 'aria-label': `${sides}. ${verdictText(overlap.verdict)}`, 'aria-pressed': String(chosen?.number === overlap.number),
      'data-focus': `overlap-${overlap.number}`, click: () => this.choose(overlap),
    }, h('span', { class: 'mark', 'aria-hidden': 'true' }, mark === 'yes' ? '✓' : '✕'),
      h('span', { class: 'text' }, sides),
      h('small', {}, reason(overlap))));
  }
}

/** What is to be known of the list as a whole. */
export function overlapsNote(isPast: boolean, all: number): string {
  const parts: string[] = [];
  if (isPast) parts.push('As they are now; the map shows those of the moment.');
  if (all >= MOST_OVERLAPS) parts.push(`There are more than ${count(MOST_OVERLAPS)}; the others are not shown.`);
  return parts.join(' ');
}

/** In a word or two, beside the mark that says whether it is believed. */
function reason(overlap: Overlap): string {
  if (isAccepted(overlap)) return `${count(overlap.inliers)} point pairs agree`;
  return decidingText(overlap) || verdictText(overlap.verdict).replace(/^(Refused[^:]*|Taken back): /, '');
}

function stageValue(value: string, bar: string, isShort: boolean): HTMLElement {
  return h('span', { class: isShort ? 'short' : '' }, value, bar && h('small', {}, ` ${bar}`));
}

/** Why an overlap was accepted or not: the verdict and all that was counted. */
export function overlapDetails(overlap: Overlap, side: (name: string) => string): Node[] {
  const rows = stageRows(overlap);
  const verdict = h('p', { class: isAccepted(overlap) ? 'verdict yes' : 'verdict no' }, verdictText(overlap.verdict));
  const state = overlap.revision > 0n ? `Taken in by revision ${count(overlap.revision)}.`
    : overlap.fused ? 'Its sides are in one island by another overlap.' : 'Not part of the map.';
  return [
    h('h3', {}, `Overlap ${overlap.number}`), verdict,
    h('p', { class: 'note' }, state),
    overlap.note ? h('p', { class: 'note' }, overlap.note) : '',
    table([
      ['Asked', side(overlap.query)], ['Candidate', side(overlap.candidate)],
      ...(overlap.inliers > 0 ? [['Point pairs that agree', count(overlap.inliers)] as [string, string]] : []),
      ...rows.filter(({ isReached }) => isReached).map(({ name, value, bar, isShort }): [string, Node] => [name, stageValue(value, bar, isShort)]),
    ]),
    rows.every(({ isReached }) => isReached) ? '' : h('p', { class: 'quiet' }, 'What else is looked at was not reached.'),
  ].filter((node): node is HTMLElement => typeof node !== 'string');
}
