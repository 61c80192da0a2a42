// What a robot is doing, as far as the store or the robot itself says it.
import { AgentActivity, type MissionAgent } from '@gen/corbslam/v1/resources_pb';
import { hexId } from './ids';
import type { MapNames } from './map_names';
import { contradictionText, count, span } from './texts';

/** How a robot is marked in the list and in the map. */
export type Doing = 'driving' | 'localising' | 'lost' | 'standing' | 'finished' | 'gone' | 'connected' | 'unknown';

/** What a robot is doing, in a word or two. */
export interface DoingText {
  doing: Doing;
  words: string;
}

/** A robot that reports does so each few seconds. */
const SILENT_S = 15;

/** `awayS`: since when the robot is away, as far as that is known. */
export function doingOf(agent: MissionAgent | undefined, awayS?: number): DoingText {
  if (!agent) return { doing: 'unknown', words: 'not known' };
  if (!agent.connected) return awayText(agent, awayS);
  const { report, reportAgeS } = agent;
  // A robot of an older version says nothing of itself.
  if (!report) return { doing: agent.localiseOnly ? 'localising' : 'connected', words: agent.localiseOnly ? 'localises' : 'connected' };
  if (report.activity === AgentActivity.FINISHED) return { doing: 'finished', words: 'finished, still there' };
  if (reportAgeS > SILENT_S) return { doing: 'lost', words: `says nothing for ${span(reportAgeS)}` };
  switch (report.activity) {
    case AgentActivity.INITIALISING: return { doing: 'standing', words: 'begins' };
    case AgentActivity.TRACKING: return agent.localiseOnly ? { doing: 'localising', words: 'localises' } : { doing: 'driving', words: 'maps' };
    case AgentActivity.LOST: return { doing: 'lost', words: 'lost' };
    case AgentActivity.WAITING: return { doing: 'standing', words: `no frames for ${span(report.newestFrameAgeS + reportAgeS)}` };
    default: return { doing: 'connected', words: 'connected' };
  }
}

function awayText({ leftOnPurpose, report }: MissionAgent, awayS: number | undefined): DoingText {
  const ago = awayS === undefined ? '' : ` ${span(awayS)} ago`;
  if (leftOnPurpose) return { doing: 'finished', words: `finished${ago}` };
  // Without a report it may be of an older version, which never says that it goes.
  if (!report) return { doing: 'gone', words: awayS === undefined ? 'offline' : `offline ${span(awayS)}` };
  return { doing: 'gone', words: `broke off${ago}` };
}

/** How old the newest frame is, and how many there were; of a report that came so long ago. */
export function reportFacts(agent: MissionAgent): [string, string][] {
  const { report, reportAgeS } = agent;
  if (!report || report.frames === 0n) return [];
  const rows: [string, string][] = [];
  const percent = Math.floor((100 * Number(report.tracked)) / Math.max(1, Number(report.frames - report.dropped)));
  rows.push(['Frames', `${count(report.frames)}, ${percent} % tracked`]);
  if (report.dropped > 0n) rows.push(['… passed over', `${count(report.dropped)}, they came too fast`]);
  if (agent.connected) rows.push(['Newest frame', `${span(report.newestFrameAgeS + reportAgeS)} old`]);
  return rows;
}

/** Which of others' maps it goes without because they are not as its own camera measures. */
export function contradictionFacts({ report }: MissionAgent, names: Pick<MapNames, 'of'>): [string, string][] {
  return (report?.contradictions ?? []).map((found) => ['Goes without', `${names.of(hexId(found.localMap))}: ${contradictionText(found)}`]);
}
