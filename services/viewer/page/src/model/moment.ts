import type { MapChange } from './map_change';
import type { MapModel } from './map_model';
import { hexId } from './ids';
import { timeOfDay } from './texts';

/** Clocks below say no date: September 2001, in nanoseconds since 1970. */
const FIRST_DATE_NS = 1_000_000_000n * 1_000_000_000n;

/** When the newest keyframe of a moment was taken, by its robot's clock. */
export interface MomentTime {
  agent: string;
  timeNs: bigint;
  /** That robot's first keyframe, as far as the past goes; clocks of other robots may be others. */
  firstNs: bigint;
}

/** Each robot's first keyframe, of all changes of a past. */
export class FirstTimes {
  private readonly agents = new Map<string, string>();
  private readonly firstNs = new Map<string, bigint>();

  add({ message }: MapChange): void {
    const table = message.localMaps.map(hexId);
    table.forEach((id, i) => message.localMapAgents[i] && this.agents.set(id, message.localMapAgents[i]));
    for (const { keyframes } of message.islands) {
      for (const { id, timestampNs } of keyframes) if (id) this.note(this.agents.get(table[id.slot - 1]) ?? '', timestampNs);
    }
  }

  of(agent: string): bigint | undefined {
    return this.firstNs.get(agent);
  }

  private note(agent: string, timeNs: bigint): void {
    const known = this.firstNs.get(agent);
    if (known === undefined || timeNs < known) this.firstNs.set(agent, timeNs);
  }
}

/**
 * The newest keyframe: by the clocks where they say dates; else the one that came last, as clocks
 * without dates can't be compared between robots.
 */
export function momentTime(model: MapModel, first: FirstTimes): MomentTime | undefined {
  let byClock: { agent: string; timeNs: bigint } | undefined;
  let last: { agent: string; arrival: number } | undefined;
  const newest = new Map<string, bigint>();
  for (const { agent, keyframes } of model.localMaps.values()) {
    for (const { slot, timestampNs } of keyframes.records.values()) {
      const arrival = keyframes.centres[4 * slot + 3];
      if (!byClock || timestampNs > byClock.timeNs) byClock = { agent, timeNs: timestampNs };
      if (!last || arrival > last.arrival) last = { agent, arrival };
      if (timestampNs > (newest.get(agent) ?? -1n)) newest.set(agent, timestampNs);
    }
  }
  if (!byClock || !last) return undefined;
  const { agent, timeNs } = hasDate(byClock.timeNs) ? byClock : { agent: last.agent, timeNs: newest.get(last.agent) ?? 0n };
  return { agent, timeNs, firstNs: first.of(agent) ?? timeNs };
}

/** `robots`: how many have keyframes then. */
export function momentText({ agent, timeNs, firstNs }: MomentTime, robots: number, nowMs = Date.now()): string {
  if (hasDate(timeNs)) return `newest keyframe ${timeOfDay(timeNs, nowMs)} by the robots’ clocks`;
  const seconds = (Number(timeNs - firstNs) / 1e9).toFixed(1);
  const whose = robots > 1 && agent ? `${agent}’s first` : 'the first';
  return `newest keyframe ${seconds} s after ${whose} by the robots’ clocks`;
}

/** A robot's time: a date where its clock has one, with the seconds that files and logs have. */
export function clockText(ns: bigint): string {
  const seconds = `${(Number(ns) / 1e9).toFixed(3)} s`;
  return hasDate(ns) ? `${timeOfDay(ns)} (${seconds})` : seconds;
}

function hasDate(ns: bigint): boolean {
  return ns >= FIRST_DATE_NS;
}
