import type { Overlap } from '@gen/corbslam/v1/overlap_pb';
import type { TrajectoryPose } from '@gen/corbslam/v1/resources_pb';
import type { Rest } from './feed/rest';
import type { MapModel } from './model/map_model';
import { Refresher } from './refresher';
import type { Stage } from './scene/stage';
import { segmentsByLocalMap, showSegments } from './scene/trajectories';
import type { ViewState } from './view_state';

/** What is not streamed but asked for while it is shown: overlaps and trajectories. */
export class Fetched {
  overlaps: Overlap[] = [];
  private state: ViewState | undefined;
  private frames: TrajectoryPose[] = [];
  private shownFrames: TrajectoryPose[] = [];
  private shownIslands = '';
  private seen = '';
  private readonly overlapsAgain: Refresher;
  private readonly framesAgain: Refresher;
  private readonly localAgain: Refresher;

  constructor(
    private readonly rest: Rest, private readonly mission: string, private readonly stage: Stage,
    private readonly model: () => MapModel, private readonly onChange: () => void,
    onEnd: (error?: unknown) => void,
  ) {
    this.overlapsAgain = new Refresher(2000, () => this.fetchOverlaps(), onEnd);
    this.framesAgain = new Refresher(5000, () => this.fetchFrames(), onEnd);
    this.localAgain = new Refresher(3000, () => this.fetchLocal(), onEnd);
  }

  /** Overlaps may have changed. */
  want(): void {
    this.ask(this.overlapsAgain);
  }

  /** A mission of which nothing came may not be there yet. */
  private ask(refresher: Refresher): void {
    if (this.model().keyframeCount > 0) refresher.want();
  }

  follow(state: ViewState): void {
    const before = this.state;
    this.state = state;
    if (state.frames && !before?.frames) this.ask(this.framesAgain);
    if (state.layer !== 'global' && before?.layer !== state.layer) this.ask(this.localAgain);
    if (state.refused !== before?.refused) this.want();
  }

  onMap(model: MapModel): void {
    if (model.keyframeCount === 0) this.forget();
    this.showFrames(model);
    const now = [model.revision, model.keyframeCount >> 3].join();
    if (now === this.seen) return;
    this.seen = now;
    this.want();
    if (this.state?.frames) this.ask(this.framesAgain);
    if (this.state?.layer !== 'global') this.ask(this.localAgain);
  }

  /** The mission is empty: it was deleted, or has not begun. */
  private forget(): void {
    if (this.overlaps.length + this.frames.length === 0) return;
    this.overlaps = this.stage.overlaps = [];
    this.frames = [];
    this.stage.updateLocal([]);
    this.seen = '';
  }

  stop(): void {
    for (const refresher of [this.overlapsAgain, this.framesAgain, this.localAgain]) refresher.stop();
  }

  private async fetchOverlaps(): Promise<void> {
    this.overlaps = await this.rest.overlaps(this.mission, !this.state?.refused);
    this.stage.overlaps = this.overlaps;
    this.stage.invalidate();
  }

  private async fetchFrames(): Promise<void> {
    this.frames = await this.rest.trajectory(this.mission, 'global');
    this.showFrames(this.model());
    this.onChange();
  }

  private async fetchLocal(): Promise<void> {
    this.stage.updateLocal(await this.rest.trajectory(this.mission, 'local'));
    this.onChange();
  }

  /**
   * Poses of frames are in the frame of an island that may be no more: those wait for the next answer.
   * They are those of now: the past has none.
   */
  private showFrames(model: MapModel): void {
    const isPast = this.stage.pastRevision !== undefined;
    const key = [isPast, ...[...model.localMaps.values()].map(({ id, island }) => id + island)].join();
    if (this.frames.length === 0 || (key === this.shownIslands && this.frames === this.shownFrames)) return;
    this.shownIslands = key;
    this.shownFrames = this.frames;
    const current = isPast ? [] : this.frames.filter(({ localMap, island }) =>
      model.localMap(localMap.slice(-16))?.island === island.slice(-16));
    const segments = segmentsByLocalMap(current);
    for (const [id, view] of this.stage.map.views) showSegments(view.frames, segments.get(id) ?? []);
  }
}
