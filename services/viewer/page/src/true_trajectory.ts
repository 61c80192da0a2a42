import { type Rest, RestError } from './feed/rest';
import { many } from './model/texts';
import { type TruePose, type TruthFit, alignTruth, dashes, dashesOfPath, parseTruth, referenceKeyframes, truthFit } from './model/truth';
import type { MapModel } from './model/map_model';
import { Refresher } from './refresher';
import type { Stage } from './scene/stage';

/**
 * Asks once whether a mission's truth is known, and then lays it on the reference island's keyframes
 * as that grows. While paths are hidden it does nothing.
 */
export class TrueTrajectory {
  private truth: TruePose[] | undefined;
  private fit: TruthFit | undefined;
  private seen = '';
  private isWanted = false;
  private readonly again: Refresher;

  constructor(
    private readonly rest: Pick<Rest, 'truth'> & Partial<Pick<Rest, 'recording'>>, private readonly mission: string,
    private readonly stage: { truth: Pick<Stage['truth'], 'show'>; invalidate(): void },
    private readonly model: () => MapModel, private readonly onChange: () => void, everyMs = 2000,
  ) {
    this.again = new Refresher(everyMs, () => this.refresh());
  }

  /** How it is shown, for people; empty: none is known. */
  words(): string {
    if (!this.truth || this.truth.length === 0) return '';
    if (!this.fit) return 'known, but fewer than 3 keyframes of the reference island are of its times';
    if (!this.isWanted) return 'hidden with the paths';
    return `dashed, laid on ${many(this.fit.common, 'keyframe')}: ${this.fit.rms.toPrecision(2)} m apart (RMS)`;
  }

  /** Whether paths, and with them the truth, are to be seen. */
  show(isWanted: boolean): void {
    this.isWanted = isWanted;
    this.onMap(this.model());
  }

  onMap(model: MapModel): void {
    if (model.keyframeCount === 0 && this.fit) this.forget();
    if (!this.isWanted || model.keyframeCount === 0 || this.truth?.length === 0) return;
    const now = [model.globalIsland, model.revision, model.keyframeCount >> 3].join();
    if (now === this.seen) return;
    this.seen = now;
    this.again.want();
  }

  /** The mission is empty: it was deleted. */
  private forget(): void {
    this.fit = undefined;
    this.seen = '';
    this.stage.truth.show([]);
    this.onChange();
  }

  stop(): void {
    this.again.stop();
  }

  /** A viewer that knows of no truths has none. */
  private async ask(): Promise<string> {
    try {
      return await this.rest.truth(this.mission);
    } catch (error) {
      if (error instanceof RestError && error.status === 404) return '';
      throw error;
    }
  }

  private async refresh(): Promise<void> {
    const recorded = this.rest.recording?.truth;
    if (recorded) return this.lay(recorded.flatMap(dashesOfPath));
    this.truth ??= parseTruth(await this.ask());
    if (this.truth.length === 0) return;
    const told = referenceKeyframes(this.model());
    const alignment = alignTruth(this.truth, told);
    this.fit = alignment ? truthFit(this.truth, told, alignment) : undefined;
    this.lay(alignment ? dashes(this.truth, alignment) : []);
  }

  private lay(segments: number[]): void {
    this.stage.truth.show(segments);
    this.onChange();
    this.stage.invalidate();
  }
}
