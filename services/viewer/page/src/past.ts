import type { Rest } from './feed/rest';
import { History } from './model/history';
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
    else void this.open().then(() => this.timeline.togglePlay());
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
  }

  private async open(): Promise<void> {
    if (this.isLoading) return;
    this.isLoading = true;
    this.timeline.open();
    const history = new History();
    try {
      await this.rest.history(this.mission, this.points() <= MOST_POINTS, (change) => history.add(change));
      this.history = history;
      this.seek(history.steps.length - 1);
      if (history.steps.length === 0) this.timeline.fail('The journal knows no past of this mission.');
    } catch (error) {
      this.timeline.fail(error instanceof Error ? error.message : String(error));
    }
    this.isLoading = false;
  }

  private seek(step: number): void {
    if (!this.history) return;
    const changes = this.history.seek(step);
    this.timeline.show(this.history.steps, this.history.position);
    this.onMap(changes);
  }
}
