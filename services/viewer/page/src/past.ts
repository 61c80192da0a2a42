import type { Rest } from './feed/rest';
import type { MissionEvent } from '@gen/corbslam/v1/events_pb';
import { History } from './model/history';
import { plainText } from './model/plain_text';
import { count, timeOfDay } from './model/texts';
import type { IslandChange, MapModel } from './model/map_model';
import { type TimelineMark, Timeline } from './panels/timeline';

/** An event, and what it says to people. */
export interface SaidEvent {
  event: MissionEvent;
  text: string;
  kind: string;
}

const MOST_POINTS = 200_000;

/** The mission's past, once it was asked for. */
export class Past {
  readonly timeline: Timeline;
  history: History | undefined;
  private isLoading = false;

  constructor(
    private readonly rest: Rest, private readonly mission: string,
    private readonly onMap: (changes: IslandChange[]) => void, private readonly points: () => number,
    private readonly onShown: (isPast: boolean) => void = () => {},
    /** What happened, oldest first, as far as the page was told. */
    private readonly events: () => readonly SaidEvent[] = () => [],
  ) {
    this.timeline = new Timeline({ seek: (step) => this.seek(step), live: () => this.live() });
  }

  /** The past's map; undefined while the live one is shown. */
  get model(): MapModel | undefined {
    return this.history && this.timeline.isOpen && this.history.steps.length > 0 ? this.history.model : undefined;
  }

  toggle(): void {
    if (this.timeline.isOpen) this.live();
    else void this.open();
  }

  play(): void {
    if (this.timeline.isOpen && this.history) this.timeline.togglePlay();
    else void this.open().then(() => this.history && this.timeline.togglePlay());
  }

  step(by: number): boolean {
    if (!this.model) return false;
    this.seek(this.history!.position + by);
    return true;
  }

  /** Where the past stands, for a link; empty: live. */
  get moment(): string {
    return this.model ? this.history!.moment(this.history!.position) : '';
  }

  /** Goes to a moment that a link names. */
  goToMoment(moment: string): void {
    this.goTo((history) => history.stepOfMoment(moment));
  }

  /** Goes to when something happened. */
  goToEvent(event: MissionEvent): void {
    this.goTo((history) => history.stepOfEvent(event));
  }

  private goTo(stepOf: (history: History) => number | undefined): void {
    const go = () => {
      const step = this.history && stepOf(this.history);
      if (step !== undefined) this.seek(step);
      else if (this.history) this.timeline.say('The past that is told does not reach to this.');
    };
    if (this.timeline.isOpen && this.history) go();
    else void this.open().then(go);
  }

  live(): void {
    if (!this.timeline.isOpen) return;
    this.close();
    this.onMap([]);
  }

  close(): void {
    this.timeline.close();
    this.history = undefined;
    this.onShown(false);
  }

  private async open(): Promise<void> {
    if (!this.rest.hasPast) return;
    this.timeline.open();
    if (this.isLoading) return;
    this.isLoading = true;
    const history = new History();
    try {
      const note = this.pointsNote();
      await this.rest.history(this.mission, note === '', (change) => history.add(change));
      this.take(history, note);
    } catch (error) {
      this.timeline.fail(plainText(error instanceof Error ? error.message : String(error)));
    }
    this.isLoading = false;
  }

  /** Why no moment has points; empty: they have. */
  private pointsNote(): string {
    const { recording } = this.rest;
    if (recording) return recording.hasPoints ? '' : 'without points';
    return this.points() <= MOST_POINTS ? '' : `without points, of which there are more than ${count(MOST_POINTS)}`;
  }

  /** Shows what came, unless nobody waits for it any more. */
  private take(history: History, note: string): void {
    if (!this.timeline.isOpen) return;
    if (history.steps.length === 0) return this.timeline.fail('The journal knows no past of this mission.');
    this.history = history;
    this.timeline.note = note;
    this.onShown(true);
    this.timeline.mark(this.marks(history), history.steps.length, (step) => this.seek(step));
    this.seek(history.steps.length - 1);
  }

  private seek(step: number): void {
    if (!this.history) return;
    const changes = this.history.seek(step);
    this.timeline.show(this.history.steps, this.history.position, this.clock(this.history));
    this.onMap(changes);
  }

  /** Events by the step that shows them first. */
  private marks(history: History): TimelineMark[] {
    const marks = new Map<number, TimelineMark>();
    for (const { event, text, kind } of this.events()) {
      const step = history.stepOfEvent(event);
      if (step === undefined) continue;
      const said = `${timeOfDay(event.timeNs)} ${text}`;
      const known = marks.get(step);
      if (known) known.words.push(said);
      else marks.set(step, { step, kind, words: [said] });
      if (kind === 'merge') marks.get(step)!.kind = kind;
    }
    return [...marks.values()].sort((a, b) => a.step - b.step);
  }

  /** By the store's clock: when the newest event happened that the moment shows. */
  private clock(history: History): string {
    let timeNs = 0n;
    for (const { event } of this.events()) {
      const step = history.stepOfEvent(event);
      if (step !== undefined && step <= history.position && event.timeNs > timeNs) timeNs = event.timeNs;
    }
    return timeNs > 0n ? `${timeOfDay(timeNs)} by the store’s clock, or later` : '';
  }
}
