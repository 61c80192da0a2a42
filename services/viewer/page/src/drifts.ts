import type { Rest } from './feed/rest';
import { type Drift, driftBetween, wayAlong } from './model/drift';
import type { LocalMapModel } from './model/local_map';
import type { MapModel } from './model/map_model';
import { wayOf } from './model/way';
import { Refresher } from './refresher';

const EVERY_MS = 5000;

/** What fusion has moved each robot by; asked for seldom, and only while somebody may read it. */
export class Drifts {
  private readonly known = new Map<string, Drift>();
  /** Of each robot, as of what it was asked for. */
  private readonly asked = new Map<string, string>();
  private readonly again: Refresher;
  private seen = '';

  constructor(
    private readonly rest: Rest, private readonly mission: string, private readonly model: () => MapModel,
    onEnd: (error?: unknown) => void,
  ) {
    this.again = new Refresher(EVERY_MS, () => this.fetch(), onEnd);
  }

  /** The list of robots is shown. */
  want(): void {
    const { revision, keyframeCount } = this.model();
    const now = [revision, keyframeCount].join();
    if (keyframeCount === 0 || now === this.seen) return;
    this.seen = now;
    this.again.want();
  }

  of(robot: string): Drift | undefined {
    return this.known.get(robot);
  }

  stop(): void {
    this.again.stop();
  }

  private async fetch(): Promise<void> {
    for (const robot of this.model().agents()) {
      const localMap = newestMapOf(this.model(), robot);
      if (!localMap || !isFused(localMap)) this.known.delete(robot);
      else await this.ask(robot, localMap);
    }
  }

  private async ask(robot: string, { id, keyframes, island }: LocalMapModel): Promise<void> {
    const slots = keyframes.slotsByTime();
    const [first, newest] = [slots[0], slots[slots.length - 1]].map((slot) => keyframes.indices[slot]);
    const { revision } = this.model();
    const key = [revision, id, island, first, newest].join();
    if (this.asked.get(robot) === key) return;
    // Through what is left of a thinned session the way would be too short.
    const wayM = wayOf(keyframes).hasGaps ? 0 : wayAlong(keyframes);
    const told = await Promise.all([first, newest].map((index) =>
      this.rest.keyframePose(this.mission, { localMap: id, index })));
    // Two answers of two revisions don't belong together: what was known stays until the next time.
    if (this.model().revision !== revision) return void (this.seen = '');
    const distanceM = driftBetween(told[0], told[1]);
    this.asked.set(robot, key);
    if (distanceM === undefined) this.known.delete(robot);
    else this.known.set(robot, { distanceM, wayM });
  }
}

/** Of a robot's local maps, the one with its newest keyframe by its clock. */
function newestMapOf(model: MapModel, robot: string): LocalMapModel | undefined {
  let best: { timeNs: bigint; localMap: LocalMapModel } | undefined;
  for (const localMap of model.localMaps.values()) {
    const newest = localMap.agent === robot ? localMap.keyframes.newest() : undefined;
    if (newest === undefined) continue;
    const { timestampNs: timeNs } = localMap.keyframes.records.get(newest)!;
    if (!best || timeNs > best.timeNs) best = { timeNs, localMap };
  }
  return best?.localMap;
}

/** Fusion gave some of its keyframes their poses. */
function isFused({ keyframes }: LocalMapModel): boolean {
  for (const { placed } of keyframes.records.values()) if (placed) return true;
  return false;
}
