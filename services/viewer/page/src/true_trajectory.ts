import type { Rest } from './feed/rest';
import { type TruePose, alignTruth, dashes, parseTruth } from './model/truth';
import type { MapModel } from './model/map_model';
import { Refresher } from './refresher';
import type { Stage } from './scene/stage';

/** Asks once whether a mission's truth is known, and then lays it on the map as that grows. */
export class TrueTrajectory {
  private truth: TruePose[] | undefined;
  private seen = '';
  private readonly again: Refresher;

  constructor(
    private readonly rest: Rest, private readonly mission: string, private readonly stage: Stage,
    private readonly model: () => MapModel, private readonly onChange: () => void,
  ) {
    this.again = new Refresher(5000, () => this.refresh());
  }

  onMap(model: MapModel): void {
    const now = [model.revision, model.keyframeCount >> 3].join();
    if (now === this.seen || model.keyframeCount === 0 || this.truth?.length === 0) return;
    this.seen = now;
    this.again.want();
  }

  stop(): void {
    this.again.stop();
  }

  private async refresh(): Promise<void> {
    this.truth ??= parseTruth(await this.rest.truth(this.mission));
    if (this.truth.length === 0) return;
    const reference = this.model().globalIsland;
    const frames = await this.rest.trajectory(this.mission, 'global');
    const alignment = alignTruth(this.truth, frames.filter(({ island }) => island.slice(-16) === reference));
    this.stage.truth.show(alignment ? dashes(this.truth, alignment) : []);
    this.onChange();
    this.stage.invalidate();
  }
}
