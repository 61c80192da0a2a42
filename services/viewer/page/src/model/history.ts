import type { MissionEvent } from '@gen/corbslam/v1/events_pb';
import { hexId, lastSegment } from './ids';
import type { MapChange } from './map_change';
import { type IslandChange, MapModel } from './map_model';
import { FirstTimes, momentTime, momentText } from './moment';

const STEPS_BETWEEN_COPIES = 10;

/** One moment of the past, behind a batch or with a revision: what changed up to it. */
export interface HistoryStep {
  revision: bigint;
  changes: MapChange[];
  /** Keyframes that were told up to it; grows from step to step. */
  told: number;
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
  private told = 0;
  /** The first step with each local map, and with each robot. */
  private readonly begun = new Map<string, number>();
  private readonly first = new FirstTimes();
  private readonly copies = new Map<number, MapModel>();

  /** The next message of ReplayMap. */
  add(change: MapChange): void {
    this.open.push(change);
    this.first.add(change);
    this.noteBegun(change);
    if (change.message.continues) return;
    this.steps.push({ revision: change.message.revision, changes: this.open, told: this.told });
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

  /** Names a step so that a link finds it again, though other steps be told by then. */
  moment(step: number): string {
    const { revision, told } = this.steps[step];
    return `${revision}.${told}`;
  }

  /** The last step that is not behind a moment. */
  stepOfMoment(moment: string): number {
    const [revision, told] = moment.split('.').map(BigInt);
    const step = this.steps.findLastIndex((one) => one.revision <= revision && BigInt(one.told) <= told);
    return Math.max(0, step);
  }

  /** The first step behind which an event lies; undefined: none of them shows it. */
  stepOfEvent({ event, revision }: MissionEvent): number | undefined {
    if (event.case === 'localMapBegun') return this.begun.get(lastSegment(event.value.localMap));
    if (event.case === 'agentJoined') return this.begun.get(`robot ${lastSegment(event.value.agent)}`);
    if (revision === 0n) return undefined;
    const step = this.steps.findIndex((one) => one.revision >= revision);
    return step < 0 ? undefined : step;
  }

  private noteBegun({ message }: MapChange): void {
    const step = this.steps.length;
    for (const { keyframes } of message.islands) {
      this.told += keyframes.length;
      for (const { id } of keyframes) {
        if (!id || id.slot < 1 || id.slot > message.localMaps.length) continue;
        const agent = message.localMapAgents[id.slot - 1];
        for (const name of [hexId(message.localMaps[id.slot - 1]), ...(agent ? [`robot ${agent}`] : [])]) {
          if (!this.begun.has(name)) this.begun.set(name, step);
        }
      }
    }
  }

  private time(): string {
    const time = momentTime(this.model, this.first);
    const seen = [...this.model.localMaps.values()].filter(({ keyframes }) => keyframes.count > 0);
    return time ? momentText(time, new Set(seen.map(({ agent }) => agent)).size) : '';
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
