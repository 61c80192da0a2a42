import type { MissionPulse } from '@gen/corbslam/v1/viewer_pb';
import type { MapModel } from '../model/map_model';
import { plainText } from '../model/plain_text';
import { bytes, count, since } from '../model/texts';
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
      ['Points drawn', drawnText(page.drawnPoints, model.pointCount)],
      ...(page.isPast || !page.isLive ? [] : thinnedRows(pulse)),
      ['Received', bytes(page.receivedBytes)],
    ];
    refill(this.body, JSON.stringify(rows), () => [table(rows)]);
  }
}

/** Of many points on few pixels some are left out: those that remain are spread over all of them. */
export function drawnText(drawn: number, all: number): string {
  if (drawn >= all) return 'all';
  return `${count(drawn)}: ${drawn === 0 ? 'none' : `1 of ${(all / drawn).toFixed(all / drawn < 10 ? 1 : 0)}`}`;
}

/** What the store let go of, of sessions that were closed. */
function thinnedRows(pulse: MissionPulse | undefined): [string, string][] {
  const sum = (of: (map: MissionPulse['localMaps'][number]) => bigint) => (pulse?.localMaps ?? []).reduce((all, map) => all + of(map), 0n);
  const [keyframes, points] = [sum((map) => map.retiredKeyframes), sum((map) => map.fadedMapPoints)];
  return [
    ...(keyframes > 0n ? [['Keyframes let go of', count(keyframes)] as [string, string]] : []),
    ...(points > 0n ? [['Points let go of', count(points)] as [string, string]] : []),
  ];
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
  if (mission) rows.push(['Fusion', fusionText(mission)]);
  if (mission && mission.workerAwaySinceNs > 0n) {
    rows.push(['Worker away for', since(mission.workerAwaySinceNs, pulse!.timeNs)]);
    if (mission.workerError) rows.push(['Why', plainText(mission.workerError)]);
  }
  return rows;
}

function fusionText(mission: NonNullable<MissionPulse['mission']>): string {
  if (mission.lacksFusionWorker) return 'no worker: maps are not fused';
  if (mission.fusionIdle) return 'all done';
  return mission.waitingQueries > 0n ? `${count(mission.waitingQueries)} look-ups wait` : 'working';
}
