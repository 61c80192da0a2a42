import type { MissionEvent } from '@gen/corbslam/v1/events_pb';
import { eventWords, timeOfDay } from '../model/words';
import { h, panel } from './dom';

const MOST_EVENTS = 200;
const MARKS = { robot: '●', merge: '◆', loop: '↻', lost: '!', other: '·' };

/** What happened, newest first. */
export class EventsPanel {
  readonly root: HTMLElement;
  private readonly list = h('ol', { class: 'events', 'aria-live': 'polite', 'aria-relevant': 'additions' });
  private readonly none = h('p', { class: 'quiet' }, 'None since the map store was started.');
  private readonly seen = new Set<string>();

  constructor() {
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
    const { kind, text } = eventWords(event);
    const item = h('li', { class: `event ${kind}` },
      h('span', { class: 'mark', 'aria-hidden': 'true' }, MARKS[kind]),
      h('span', { class: 'text' }, text),
      h('time', {}, timeOfDay(event.timeNs)));
    if (kind === 'merge' && isRecent) item.classList.add('flash');
    this.list.prepend(item);
    while (this.list.children.length > MOST_EVENTS) this.list.lastElementChild!.remove();
    return true;
  }
}
