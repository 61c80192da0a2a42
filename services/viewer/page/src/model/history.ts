import type { MapChange } from './map_change';
import { type IslandChange, MapModel } from './map_model';
import { FirstTimes, momentTime, momentWords } from './moment';

const STEPS_BETWEEN_COPIES = 10;

/** One moment of the past, behind a batch or with a revision: what changed up to it. */
export interface HistoryStep {
  revision: bigint;
  changes: MapChange[];
  /** What is there after it, once it was shown. */
  summary?: { islands: number; keyframes: number };
  /** When its newest keyframe was taken, in words, once it was shown. */
  time?: string;
}

/** A mission's past: going forward applies changes, going back begins at the nearest kept copy. */
export class History {
  readonly steps: HistoryStep[] = [];
  model = new MapModel();
  position = -1;
  private open: MapChange[] = [];
  private readonly first = new FirstTimes();
  private readonly copies = new Map<number, MapModel>();

  /** The next message of ReplayMap. */
  add(change: MapChange): void {
    this.open.push(change);
    this.first.add(change);
    if (change.message.continues) return;
    this.steps.push({ revision: change.message.revision, changes: this.open });
    this.open = [];
  }

  /** Goes to a step; returns what joined other islands where one step forward was taken. */
  seek(target: number): IslandChange[] {
    const wanted = Math.max(0, Math.min(target, this.steps.length - 1));
    if (this.steps.length === 0 || wanted === this.position) return [];
    if (wanted < this.position) this.restore(wanted);
    let changes: IslandChange[] = [];
    while (this.position < wanted) changes = this.advance();
    this.steps[wanted].time ??= this.time();
    return changes;
  }

  private time(): string {
    const time = momentTime(this.model, this.first);
    const seen = [...this.model.localMaps.values()].filter(({ keyframes }) => keyframes.count > 0);
    return time ? momentWords(time, new Set(seen.map(({ agent }) => agent)).size) : '';
  }

  private advance(): IslandChange[] {
    this.position++;
    const step = this.steps[this.position];
    const changes = this.model.apply(step.changes);
    step.summary ??= { islands: this.model.islands().size, keyframes: this.model.keyframeCount };
    if (this.position % STEPS_BETWEEN_COPIES === 0 && !this.copies.has(this.position)) {
      this.copies.set(this.position, this.model.copy());
    }
    return changes;
  }

  private restore(target: number): void {
    const kept = [...this.copies.keys()].filter((position) => position <= target);
    this.position = kept.length > 0 ? Math.max(...kept) : -1;
    this.model = this.copies.get(this.position)?.copy() ?? new MapModel();
  }
}
