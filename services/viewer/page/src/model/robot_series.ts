import type { MissionPulse } from '@gen/corbslam/v1/viewer_pb';
import { lastSegment } from './ids';

/** What was told of a robot at one time. */
export interface RobotSample {
  timeS: number;
  /** Frames that were tracked, in each second since the sample before. */
  trackedPerS: number | undefined;
  /** How old the newest frame was. */
  ageS: number | undefined;
  /** Own map points in the robot's memory, which it tracks; only robots that are asked themselves tell it. */
  points: number | undefined;
}

/** A sample each second or so: ten minutes and more. */
const MOST_SAMPLES = 600;
/** A report that is not newer says nothing of the time since. */
const LEAST_S = 0.5;

interface Counted {
  timeS: number;
  tracked: number;
}

/** How robots did over the last minutes, as pulses told it. */
export class RobotSeries {
  private readonly samples = new Map<string, RobotSample[]>();
  private readonly last = new Map<string, Counted>();

  of(robot: string): readonly RobotSample[] {
    return this.samples.get(robot) ?? [];
  }

  /** Whether anything was told of any robot. */
  get robots(): string[] {
    return [...this.samples.keys()];
  }

  note(pulse: MissionPulse): void {
    const nowS = Number(pulse.timeNs / 1_000_000n) / 1000;
    const asked = new Set<string>();
    for (const { agent, status } of pulse.robots) {
      if (!status) continue;
      const robot = lastSegment(agent);
      asked.add(robot);
      const ageS = status.newestFrameAgeS > 0 ? status.newestFrameAgeS : undefined;
      this.add(robot, { timeS: nowS, tracked: Number(status.tracked) }, ageS, Number(status.mapPoints));
    }
    for (const { name, connected, report, reportAgeS } of pulse.agents) {
      const robot = lastSegment(name);
      if (!connected || !report || asked.has(robot)) continue;
      const counted = { timeS: nowS - reportAgeS, tracked: Number(report.tracked) };
      this.add(robot, counted, report.newestFrameAgeS, undefined);
    }
  }

  private add(robot: string, counted: Counted, ageS: number | undefined, points: number | undefined): void {
    const before = this.last.get(robot);
    const stepS = before ? counted.timeS - before.timeS : Infinity;
    if (stepS < LEAST_S) return;
    this.last.set(robot, counted);
    // A robot that began anew counts from 0.
    const isCounted = before !== undefined && counted.tracked >= before.tracked;
    const trackedPerS = isCounted ? (counted.tracked - before.tracked) / stepS : undefined;
    const all = this.samples.get(robot) ?? [];
    all.push({ timeS: counted.timeS, trackedPerS, ageS, points });
    if (all.length > MOST_SAMPLES) all.shift();
    this.samples.set(robot, all);
  }
}
