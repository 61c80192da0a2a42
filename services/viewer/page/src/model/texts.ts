// What people read, made of what the wire says. Everything here is plain text.
import type { MissionEvent } from '@gen/corbslam/v1/events_pb';
import { type Overlap, OverlapVerdict } from '@gen/corbslam/v1/overlap_pb';
import { type AgentStatus, TrackingState, WhyNoPose } from '@gen/corbslam/v1/agent_service_pb';
import { AgentActivity, type MapContradiction, type Mission } from '@gen/corbslam/v1/resources_pb';
import type { MapNames } from './map_names';
import { lastSegment } from './ids';

const VERDICTS: Record<OverlapVerdict, string> = {
  [OverlapVerdict.UNSPECIFIED]: 'No verdict yet.',
  [OverlapVerdict.ACCEPTED]: 'Accepted: the two sides can be fused.',
  [OverlapVerdict.TOO_FEW_WORD_MATCHES]: 'Refused: too few keypoints look alike.',
  [OverlapVerdict.TOO_FEW_RANSAC_INLIERS]:
    'Refused: no single motion explains enough of the matched keypoints.',
  [OverlapVerdict.TOO_FEW_REFINED_INLIERS]:
    'Refused: too few matches were left after the motion was refined.',
  [OverlapVerdict.TOO_FEW_PROJECTED_MATCHES]:
    'Refused: too few points of the neighbourhood were found where they should be.',
  [OverlapVerdict.NO_SECOND_KEYFRAME]:
    'Refused: no second pair of keyframes agrees.',
  [OverlapVerdict.WRONG_SCALE]: 'Refused: two metric maps differ in scale, or nothing tells the scale of one without metres.',
  [OverlapVerdict.BENDS_GRAPH]:
    'Refused while fusing: it contradicts what is already known.',
  [OverlapVerdict.TAKEN_BACK]:
    'Taken back: it was accepted once and is not believed any more.',
};

export function verdictText(verdict: OverlapVerdict): string {
  return VERDICTS[verdict] ?? 'Refused, for a reason that this page does not know.';
}

export function isAccepted(overlap: Overlap): boolean {
  return overlap.verdict === OverlapVerdict.ACCEPTED;
}

const STATES: Record<TrackingState, string> = {
  [TrackingState.UNSPECIFIED]: 'not known',
  [TrackingState.INITIALISING]: 'initialising',
  [TrackingState.TRACKING]: 'tracking',
  [TrackingState.LOST]: 'lost',
};

const WHY: Partial<Record<WhyNoPose, string>> = {
  [WhyNoPose.FEW_KEYPOINTS]: 'the picture has too few corners',
  [WhyNoPose.FEW_DEPTHS]: 'too few corners have a depth',
  [WhyNoPose.MAPPING_BUSY]: 'mapping still works on earlier frames',
  [WhyNoPose.MAPPING_PAUSED]: 'there is no map, and mapping is paused',
  [WhyNoPose.NOT_RECOGNISED]: 'the place is not recognised',
};

export function trackingText({ state, whyNoPose, activity }: Pick<AgentStatus, 'state' | 'whyNoPose'> & { activity?: AgentActivity }): string {
  if (activity === AgentActivity.FINISHED) return 'finished: no frame will come';
  if (activity === AgentActivity.WAITING) return 'no frames come';
  const why = state === TrackingState.TRACKING ? undefined : WHY[whyNoPose];
  return (STATES[state] ?? 'not known') + (why ? `: ${why}` : '');
}

/** What is wrong with a mission that answers, for people; empty: nothing. */
export function missionTrouble(mission: Mission | undefined): string {
  if (!mission?.damage) return '';
  return `The mission's journal is damaged; it takes nothing in, and what could not be read is not shown: ${mission.damage.replace(/\.$/, '')}.`;
}

/** An event as a sentence, and its kind for the list's marks. */
export interface EventText {
  kind: 'robot' | 'merge' | 'loop' | 'lost' | 'other';
  text: string;
}

const robot = (name: string) => lastSegment(name);
const list = (names: string[]) =>
  names.length < 2 ? names.join() : `${names.slice(0, -1).join(', ')} and ${names.at(-1)}`;
export const many = (n: number | bigint, one: string, more = `${one}s`) => `${count(n)} ${Number(n) === 1 ? one : more}`;

export function eventText({ event }: MissionEvent, names: MapNames): EventText {
  const map = (name: string) => names.of(lastSegment(name));
  switch (event.case) {
    case 'agentJoined':
      return { kind: 'robot', text: `${robot(event.value.agent)} joined` };
    case 'agentLeft':
      return { kind: 'robot', text: `${robot(event.value.agent)} ${event.value.onPurpose ? 'finished and left' : 'is away: its connection ended'}` };
    case 'localMapBegun':
      return { kind: 'robot', text: `${robot(event.value.agent)} began ${names.ownOf(lastSegment(event.value.localMap))}` };
    case 'trackingLost':
      return { kind: 'lost', text: `${robot(event.value.agent)} lost tracking for ${many(event.value.frames, 'frame')}` };
    case 'mapContradicted':
      return { kind: 'lost', text: `${robot(event.value.agent)} goes without ${map(event.value.localMap)}: ${contradictionText(event.value.found)}` };
    case 'overlapAccepted':
      return { kind: 'other', text: overlapText(event.value.localMaps.map(map)) };
    default:
      return fusionText(event, names);
  }
}

function fusionText(event: MissionEvent['event'], names: MapNames): EventText {
  switch (event.case) {
    case 'islandsMerged':
      return { kind: 'merge', text: mergeText(event.value.agents, event.value.localMaps.length, event.value.ms) };
    case 'loopClosed':
      return { kind: 'loop', text: loopText(event.value.overlaps, event.value.localMaps.map((name) => names.of(lastSegment(name)))) };
    case 'mapAdjusted':
      return { kind: 'other', text: `Map adjusted: ${many(event.value.keyframes, 'keyframe')} in ${seconds(event.value.ms)}` };
    case 'overlapsTakenBack':
      return { kind: 'lost', text: `${many(event.value.overlaps.length, 'overlap')} taken back` };
    case 'globalLayerForgotten':
      return { kind: 'lost', text: 'All that fusion found was forgotten; it is looked for again' };
    default:
      return { kind: 'other', text: 'Something happened that this page does not know' };
  }
}

/** How the other map is. */
export function contradictionText(found: MapContradiction | undefined): string {
  const { scale = 1, bend } = found ?? {};
  if (bend) {
    const degrees = (bend.turnRad * 180) / Math.PI;
    return `bent, over ${bend.wayM.toFixed(1)} m its camera turns otherwise by ${degrees.toFixed(1)}°`;
  }
  return `${(100 * Math.abs(scale - 1)).toFixed(2)} % ${scale > 1 ? 'larger' : 'smaller'} than its camera measures`;
}

/** A loop that its robot closed comes without overlaps of the store. */
function loopText(overlaps: number, maps: string[]): string {
  const where = maps.length > 0 && maps.length < 4 ? ` in ${list(maps)}` : '';
  return overlaps > 0 ? `Loop closed${where} by ${many(overlaps, 'overlap')}` : `Loop closed${where} by the robot itself`;
}

function mergeText(agents: string[], maps: number, ms: number): string {
  const owners = list(agents.map(robot));
  return `Maps of ${owners} became one (${many(maps, 'local map')}, ${seconds(ms)})`;
}

function overlapText(maps: string[]): string {
  const [a, b] = maps;
  if (a === b) return `Overlap accepted within ${a}`;
  return `Overlap accepted between ${list(maps)}`;
}

function seconds(ms: number): string {
  return ms < 1000 ? `${Math.round(ms)} ms` : `${(ms / 1000).toFixed(1)} s`;
}

/** What is in the picture. */
export function mapText(model: { islands(): Map<string, unknown>; agents(): string[]; keyframeCount: number; pointCount: number }): string {
  if (model.keyframeCount === 0) return 'nothing yet';
  const parts = [many(model.islands().size, 'island'), many(model.keyframeCount, 'keyframe'), many(model.pointCount, 'point')];
  return `${parts.join(', ')} of ${list(model.agents()) || 'robots without a name'}`;
}

/** A number with thin spaces between thousands. */
export function count(n: number | bigint): string {
  return n.toString().replace(/\B(?=(\d{3})+(?!\d))/g, '\u2009');
}

export function bytes(n: number | bigint): string {
  const value = Number(n);
  if (value < 1000) return `${value} B`;
  const unit = value < 1e6 ? 'kB' : value < 1e9 ? 'MB' : 'GB';
  const scaled = value / (value < 1e6 ? 1e3 : value < 1e9 ? 1e6 : 1e9);
  return `${scaled < 10 ? scaled.toFixed(1) : Math.round(scaled)} ${unit}`;
}

/** Local time of day of a store's or viewer's clock, with the date where that is another day's than now. */
export function timeOfDay(ns: bigint, nowMs = Date.now()): string {
  const [time, now] = [new Date(Number(ns / 1_000_000n)), new Date(nowMs)];
  const clock = time.toLocaleTimeString();
  if (time.toDateString() === now.toDateString()) return clock;
  const year = time.getFullYear() === now.getFullYear() ? undefined : 'numeric';
  return `${time.toLocaleDateString([], { day: 'numeric', month: 'short', year })}, ${clock}`;
}

/** How long something has lasted, in a word or two. */
export function since(ns: bigint, nowNs: bigint): string {
  return span(Number((nowNs - ns) / 1_000_000n) / 1000);
}

/** A time of so many seconds. */
export function span(seconds: number): string {
  const s = Math.max(0, Math.round(seconds));
  if (s < 60) return `${s} s`;
  if (s < 3600) return `${Math.floor(s / 60)} min`;
  return s < 86_400 ? `${Math.floor(s / 3600)} h ${Math.floor((s % 3600) / 60)} min` : `${Math.floor(s / 86_400)} d ${Math.floor((s % 86_400) / 3600)} h`;
}
