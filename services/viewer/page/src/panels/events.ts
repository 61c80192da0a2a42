import type { MissionEvent } from '@gen/corbslam/v1/events_pb';
import type { MapNames } from '../model/map_names';
import { eventText, many, timeOfDay } from '../model/texts';
import { h, panel } from './dom';

const MOST_EVENTS = 200;
const MARKS = { robot: '●', merge: '◆', loop: '↻', lost: '!', other: '·' };

/** What happened, newest first. */
export class EventsPanel {
  readonly root: HTMLElement;
  private readonly list = h('ol', { class: 'events', 'aria-live': 'polite', 'aria-relevant': 'additions' });
  private readonly none = h('p', { class: 'quiet' }, 'None since the map store was started.');
  private readonly seen = new Set<string>();
  private readonly shown: { event: MissionEvent; item: HTMLElement; text: HTMLElement }[] = [];
  private namesVersion = 0;

  constructor(private readonly names: MapNames, private readonly goTo: (event: MissionEvent) => void = () => {}) {
    const { root, body } = panel('events', 'Events');
    this.root = root;
    body.append(this.none, this.list);
  }

  /** Adds an event. Returns whether it is new: after a reconnection some come again. */
  add(event: MissionEvent, isRecent: boolean): boolean {
    const key = `${event.number} ${event.timeNs}`;
    if (this.seen.has(key)) return false;
    this.seen.add(key);
    this.none.remove();
    if (event.missed > 0n) this.addRow('other', `${many(Number(event.missed), 'earlier event')} forgotten by the store`);
    const { kind, text } = eventText(event, this.names);
    const { item, words } = this.addRow(kind, text, event);
    if (kind === 'merge' && isRecent) item.classList.add('flash');
    this.shown.push({ event, item, text: words });
    while (this.list.children.length > MOST_EVENTS) this.list.lastElementChild!.remove();
    if (this.shown.length > MOST_EVENTS) this.shown.shift();
    return true;
  }

  /** What happened, oldest first. */
  get said(): { event: MissionEvent; text: string; kind: string }[] {
    return this.shown.map(({ event }) => ({ event, ...eventText(event, this.names) }));
  }

  /** Says local maps' names that came after their events. */
  rename(): void {
    if (this.namesVersion === this.names.version) return;
    this.namesVersion = this.names.version;
    for (const { event, text } of this.shown) {
      const words = eventText(event, this.names).text;
      if (text.textContent !== words) text.textContent = words;
    }
  }

  private addRow(kind: keyof typeof MARKS, text: string, event?: MissionEvent): { item: HTMLElement; words: HTMLElement } {
    const words: HTMLElement = event
      ? h('button', { type: 'button', class: 'text', title: 'Show the map as it was then', click: () => this.goTo(event) }, text)
      : h('span', { class: 'text' }, text);
    const time = event && new Date(Number(event.timeNs / 1_000_000n));
    const item = h('li', { class: `event ${kind}` },
      h('span', { class: 'mark', 'aria-hidden': 'true' }, MARKS[kind]), words,
      event && h('time', { datetime: time!.toISOString(), title: time!.toLocaleString() }, timeOfDay(event.timeNs)));
    this.list.prepend(item);
    return { item, words };
  }
}
