import type { Rest } from './feed/rest';
import { History } from './model/history';
import { count } from './model/words';
import type { IslandChange, MapModel } from './model/map_model';
import { Timeline } from './panels/timeline';

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
    this.timeline.open();
    if (this.isLoading) return;
    this.isLoading = true;
    const history = new History();
    try {
      const hasPoints = this.points() <= MOST_POINTS;
      await this.rest.history(this.mission, hasPoints, (change) => history.add(change));
      this.take(history, hasPoints);
    } catch (error) {
      this.timeline.fail(error instanceof Error ? error.message : String(error));
    }
    this.isLoading = false;
  }

  /** Shows what came, unless nobody waits for it any more. */
  private take(history: History, hasPoints: boolean): void {
    if (!this.timeline.isOpen) return;
    if (history.steps.length === 0) return this.timeline.fail('The journal knows no past of this mission.');
    this.history = history;
    this.timeline.note = hasPoints ? '' : `without points, of which there are more than ${count(MOST_POINTS)}`;
    this.onShown(true);
    this.seek(history.steps.length - 1);
  }

  private seek(step: number): void {
    if (!this.history) return;
    const changes = this.history.seek(step);
    this.timeline.show(this.history.steps, this.history.position);
    this.onMap(changes);
  }
}
