import type { MissionPulse } from '@gen/corbslam/v1/viewer_pb';
import type { MapModel } from '../model/map_model';
import { bytes, count, since } from '../model/words';
import { panel, refill, table } from './dom';

/** Figures of this page itself. */
export interface PageFigures {
  receivedBytes: number;
  /** How the truth is shown; empty: none is known. */
  truth: string;
  /** The map is one of the past. */
  isPast: boolean;
  /** What is shown beside the past though it is of now. */
  ofNow: string[];
  /** What the pulse says is how things are now. */
  isLive: boolean;
  drawnPoints: number;
}

/** The mission in numbers. */
export class NumbersPanel {
  readonly root: HTMLElement;
  private readonly body: HTMLElement;

  constructor() {
    ({ root: this.root, body: this.body } = panel('numbers', 'Numbers'));
  }

  update(model: MapModel, pulse: MissionPulse | undefined, page: PageFigures): void {
    const rows: [string, string][] = [
      ...(page.isPast ? [['Shown', 'the past'] as [string, string], ...page.ofNow.map((what): [string, string] => [what, 'known of now alone'])] : []),
      ['Revision', count(model.revision)],
      ['Islands', String(model.islands().size)],
      ['Keyframes', count(model.keyframeCount)],
      ['Map points', count(model.pointCount)],
      ...(page.isPast || !page.isLive ? [] : fusionRows(pulse)),
      ...(page.truth ? [['Truth', page.truth] as [string, string]] : []),
      ['Points drawn', count(page.drawnPoints)],
      ['Received', bytes(page.receivedBytes)],
    ];
    refill(this.body, JSON.stringify(rows), () => [table(rows)]);
  }
}

function fusionRows(pulse: MissionPulse | undefined): [string, string][] {
  const rows: [string, string][] = [];
  const { statistics, mission } = pulse ?? {};
  if (statistics) {
    rows.push(['Places looked up', count(statistics.overlapsQueried)]);
    rows.push(['Overlaps verified', count(statistics.overlapsVerified)]);
    rows.push(['Overlaps accepted', count(statistics.overlapsAccepted)]);
  }
  if (statistics && statistics.failedRequests > 0n) rows.push(['Requests that failed', count(statistics.failedRequests)]);
  if (mission?.asleep) rows.push(['Mission', 'asleep: on the store’s disk alone']);
  if (mission) rows.push(['Fusion', fusionWords(mission)]);
  if (mission && mission.workerAwaySinceNs > 0n) {
    rows.push(['Worker away for', since(mission.workerAwaySinceNs, pulse!.timeNs)]);
    if (mission.workerError) rows.push(['Worker said', mission.workerError]);
  }
  return rows;
}

function fusionWords(mission: NonNullable<MissionPulse['mission']>): string {
  if (mission.lacksFusionWorker) return 'no worker: maps are not fused';
  if (mission.fusionIdle) return 'all done';
  return mission.waitingQueries > 0n ? `${count(mission.waitingQueries)} look-ups wait` : 'working';
}
