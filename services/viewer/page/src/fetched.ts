import type { Overlap } from '@gen/corbslam/v1/overlap_pb';
import type { TrajectoryPose } from '@gen/corbslam/v1/resources_pb';
import type { MissionPulse } from '@gen/corbslam/v1/viewer_pb';
import type { Rest } from './feed/rest';
import { type Driven, drivenPaths } from './model/driven';
import { lastSegment } from './model/ids';
import type { MapModel } from './model/map_model';
import type { Vec3 } from './model/vector';
import { Refresher } from './refresher';
import type { Stage } from './scene/stage';
import { segmentsByLocalMap, showSegments } from './scene/trajectories';
import type { ViewState } from './view_state';

/** All frames of a long mission are much: they are asked for so seldom that they take a small part of the time. */
const DRIVEN_EVERY_MS = 10_000;
const DRIVEN_PART = 20;

/** What is not streamed but asked for while it is shown: overlaps and trajectories. */
export class Fetched {
  overlaps: Overlap[] = [];
  private state: ViewState | undefined;
  private frames: TrajectoryPose[] = [];
  private shownFrames: TrajectoryPose[] = [];
  private shownIslands = '';
  private seen = '';
  private driven: Driven | undefined;
  private seenDriven = '';
  private shownDriven: Driven | undefined;
  private shownAlone = 0;
  private readonly overlapsAgain: Refresher;
  private readonly drivenAgain: Refresher;
  private readonly framesAgain: Refresher;
  private readonly localAgain: Refresher;

  constructor(
    private readonly rest: Rest, private readonly mission: string, private readonly stage: Stage,
    private readonly model: () => MapModel, private readonly onChange: () => void,
    onEnd: (error?: unknown) => void,
  ) {
    this.overlapsAgain = new Refresher(2000, () => this.fetchOverlaps(), onEnd);
    this.framesAgain = new Refresher(5000, () => this.fetchFrames(), onEnd);
    this.drivenAgain = new Refresher(DRIVEN_EVERY_MS, () => this.fetchDriven(), onEnd);
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

  /** Asks where all frames were, if keyframes alone do not say where robots drove. */
  wantDriven(pulse: MissionPulse | undefined): void {
    if (!this.state?.paths || this.stage.pastRevision !== undefined) return;
    const model = this.model();
    // Who only localised and is away is one without local maps: the store knows it of sessions that stand.
    const localisers = pulse?.agents.filter(({ localiseOnly, localMaps }) => localiseOnly || localMaps.length === 0) ?? [];
    const isLeft = (name: string) => (model.localMap(lastSegment(name))?.keyframes.count ?? 0) > 0;
    const bare = pulse?.localMaps.filter(({ name, trackedFrames }) => trackedFrames > 0n && !isLeft(name)) ?? [];
    if (localisers.length + bare.length === 0 && !this.stage.map.hasGaps) return;
    const moves = localisers.some(({ connected }) => connected) ? Math.floor(performance.now() / DRIVEN_EVERY_MS) : 0;
    const now = [model.revision, model.keyframeCount >> 4, model.localMaps.size, localisers.length, bare.length, moves].join();
    if (now === this.seenDriven) return;
    this.seenDriven = now;
    this.ask(this.drivenAgain);
  }

  /** Where the last run of a robot that only localised has ended, and in which island; undefined: it has none. */
  lastLocalised(robot: string): { island: string; place: Vec3 } | undefined {
    const run = this.stage.pastRevision === undefined ? this.driven?.runs.findLast(({ agent }) => agent === robot) : undefined;
    const [x, y, z] = run?.places.slice(-3) ?? [];
    return run && { island: run.island, place: [x, y, z] };
  }

  onMap(model: MapModel): void {
    if (model.keyframeCount === 0) this.forget();
    this.showFrames(model);
    this.showDriven(model);
    const now = [model.revision, model.keyframeCount >> 3].join();
    if (now === this.seen) return;
    this.seen = now;
    this.want();
    if (this.state?.frames) this.ask(this.framesAgain);
    if (this.state?.layer !== 'global') this.ask(this.localAgain);
  }

  /** The mission is empty: it was deleted, or has not begun. */
  private forget(): void {
    if (this.overlaps.length + this.frames.length === 0 && !this.driven) return;
    this.overlaps = this.stage.overlaps = [];
    this.frames = [];
    this.driven = undefined;
    this.seenDriven = '';
    this.stage.runs.show([]);
    this.stage.updateLocal([]);
    this.seen = '';
  }

  stop(): void {
    for (const refresher of [this.overlapsAgain, this.framesAgain, this.localAgain, this.drivenAgain]) refresher.stop();
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

  private async fetchDriven(): Promise<void> {
    const begunMs = performance.now();
    this.driven = drivenPaths(await this.rest.trajectory(this.mission, 'global'));
    this.drivenAgain.everyMs = Math.max(DRIVEN_EVERY_MS, DRIVEN_PART * (performance.now() - begunMs));
    this.showDriven(this.model());
    this.stage.invalidate();
  }

  /** As `showFrames`: of now alone, and in the frames of islands that are there. */
  private showDriven(model: MapModel): void {
    if (!this.driven) return;
    const driven = this.stage.pastRevision === undefined ? this.driven : undefined;
    for (const [id, view] of this.stage.map.views) {
      const path = driven?.localMaps.get(id);
      if (view.driven === path) continue;
      view.driven = path;
      view.syncPath();
    }
    const alone = [...(driven?.localMaps ?? [])].filter(([id]) => !model.localMap(id)?.keyframes.count).map(([, path]) => path);
    const paths = [...(driven?.runs ?? []), ...alone];
    if (paths.length + this.stage.runs.count === 0 || (driven === this.shownDriven && alone.length === this.shownAlone)) return;
    [this.shownDriven, this.shownAlone] = [driven, alone.length];
    this.stage.runs.show(paths);
    this.stage.runs.place(this.stage.map);
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
