// A mission that goes on by itself: robots drive, islands merge, overlaps come.
import { create } from '@bufbuild/protobuf';
import { type MissionEvent, MissionEventSchema } from '@gen/corbslam/v1/events_pb';
import { type WatchMapResponse, WatchMapResponseSchema } from '@gen/corbslam/v1/map_store_service_pb';
import { type Overlap, OverlapSchema, OverlapVerdict } from '@gen/corbslam/v1/overlap_pb';
import { hexId } from '../src/model/ids';
import { Random } from '../src/model/random';
import type { Quat, Vec3 } from '../src/model/vector';
import { type Robot, type StreetKeyframe, cameraFromFrame, driveTo, makeRobots, seePoint, toOwnFrame, turnToOwnFrame } from './street';

interface Keyframe { world: StreetKeyframe; timeNs: bigint }

export interface SimulatedRobot {
  robot: Robot;
  keyframes: Keyframe[];
  points: Vec3[];
  /** Whose frame it is in: the number of the robot that names the island. */
  island: number;
  distance: number;
  /** By its clock. */
  startNs: bigint;
  /** Its session is closed, and of its keyframes few are left. */
  isThinned: boolean;
}

/** Of a thinned session these are left. */
export const isLeft = (index: number) => index < 3 || index % 23 === 0;

const STEP_M = 1.4;
export const now = () => BigInt(Date.now()) * 1_000_000n;

export class SimulatedMission {
  readonly robots: SimulatedRobot[];
  readonly overlaps: Overlap[] = [];
  readonly events: MissionEvent[] = [];
  readonly past: WatchMapResponse[] = [];
  revision = 0n;
  version = 0n;
  private readonly random = new Random(7);
  /** As a store of an older version tells it. */
  isOld = false;
  /** A robot that only localises drives, too. */
  hasLocaliser = false;

  constructor(readonly name: string, count: number, readonly pointsPerKeyframe: number) {
    this.robots = makeRobots(count, this.random).map((robot, island) => ({ robot, keyframes: [], points: [], island, distance: 0, startNs: BigInt(island) * 10n ** 13n, isThinned: false }));
    for (const { robot } of this.robots) {
      this.happen({ case: 'agentJoined', value: { agent: `missions/${name}/agents/${robot.name}` } });
      this.happen({ case: 'localMapBegun', value: { agent: `agents/${robot.name}`, localMap: `localMaps/${hexId(robot.id)}` } });
    }
  }

  /** Every robot drives on; returns what is new. */
  drive(steps: number): WatchMapResponse {
    const changed = this.robots.map((one) => ({ one, from: [one.keyframes.length, one.points.length] }));
    for (const { one } of changed) {
      for (let i = 0; i < steps && !one.isThinned; i++) this.step(one);
    }
    if (this.random.below(12) === 0) this.refuse();
    const islands = changed.map(({ one, from }) => this.island(one, from[0], from[1], false));
    return this.record(this.message(islands, [], false));
  }

  /** Some points that came together move a little, as when the keyframes that see them are adjusted. */
  move(points: number): WatchMapResponse {
    const one = this.robots[this.random.below(this.robots.length)];
    const from = this.random.below(Math.max(1, one.points.length - points));
    for (let i = from; i < Math.min(from + points, one.points.length); i++) one.points[i][1] += 0.01;
    return this.message([this.island(one, one.keyframes.length, from, false, from + points)], [], false);
  }

  /** Every robot drives on, and nobody is told: how a large map begins. */
  begin(steps: number): void {
    for (const one of this.robots) for (let i = 0; i < steps; i++) this.step(one);
  }

  /** The island of one robot goes into that of another. */
  merge(from: number, into: number): WatchMapResponse {
    const [a, b] = [this.robots[into], this.robots[from]];
    this.accept(a, b);
    this.revision++;
    const name = (one: SimulatedRobot) => `missions/${this.name}/localMaps/${hexId(one.robot.id)}`;
    for (const one of this.robots) if (one.island === from) one.island = into;
    const members = this.robots.filter(({ island }) => island === into);
    this.happen({ case: 'islandsMerged', value: { localMaps: members.map(name), agents: members.map(({ robot }) => `agents/${robot.name}`), ms: 412 } });
    return this.record(this.message(members.map((one) => this.island(one, 0, 0, false)), [from + 1], false));
  }

  /** The whole map, in pieces: keyframes first, then points. */
  *picture(): Generator<WatchMapResponse> {
    const islands = this.robots.map((one) => this.island(one, 0, one.points.length, one.island === this.robots.indexOf(one)));
    islands.sort((a, b) => Number(b.anew) - Number(a.anew));
    yield this.message(islands, [], true);
    for (const one of this.robots) {
      for (let at = 0; at < one.points.length; at += 50_000) {
        yield this.message([this.island(one, one.keyframes.length, at, false, at + 50_000)], [], true);
      }
    }
    yield this.message([], [], false);
  }

  happen(event: { case: string; value: object }): MissionEvent {
    const told = create(MissionEventSchema, {
      number: BigInt(this.events.length + 1), timeNs: now(), revision: this.revision, event: event as never,
    });
    this.events.push(told);
    return told;
  }

  pose(one: SimulatedRobot, { world }: Keyframe): { centre: Vec3; rotation: Quat } {
    const frame = this.robots[one.island].robot;
    return { centre: toOwnFrame(frame, world.centre), rotation: turnToOwnFrame(frame, world.rotation) };
  }

  keyframeName(one: SimulatedRobot, index: number): string {
    return `missions/${this.name}/localMaps/${hexId(one.robot.id)}/keyframes/${index}`;
  }

  private step(one: SimulatedRobot): void {
    const world = driveTo(one.robot, one.distance);
    one.keyframes.push({ world, timeNs: one.startNs + BigInt(Math.round(one.distance * 1e8)) });
    for (let i = 0; i < this.pointsPerKeyframe; i++) one.points.push(seePoint(world, this.random));
    one.distance += STEP_M;
  }

  private island(one: SimulatedRobot, fromKeyframe: number, fromPoint: number, anew: boolean, toPoint = Infinity) {
    const slot = this.robots.indexOf(one) + 1;
    const frame = this.robots[one.island].robot;
    const points = one.points.slice(fromPoint, toPoint);
    return {
      slot: one.island + 1, anew, inGlobalFrame: one.island === 0, localMapSlots: [one.island + 1, slot],
      keyframes: one.keyframes.slice(fromKeyframe).flatMap((keyframe, i) => {
        const { centre, rotation } = this.pose(one, keyframe);
        const index = fromKeyframe + i;
        if (one.isThinned && !isLeft(index)) return [];
        return [{
          id: { slot, index }, timestampNs: keyframe.timeNs, placed: one.island === 0,
          cameraFromIsland: cameraFromFrame(centre, rotation),
          parent: index > 0 ? { slot, index: index - 1 } : undefined,
        }];
      }),
      points: {
        ids: { slots: points.map(() => slot), indexDeltas: points.map((_, i) => BigInt(i === 0 ? fromPoint : 1)) },
        positions: points.flatMap((point) => toOwnFrame(frame, point)),
      },
      pointObservations: this.isOld ? [] : points.map((_, i) => observationsOf(fromPoint + i)),
    };
  }

  private message(islands: object[], removedIslandSlots: number[], continues: boolean): WatchMapResponse {
    return create(WatchMapResponseSchema, {
      version: ++this.version, revision: this.revision, continues, removedIslandSlots, islands: islands as never,
      localMaps: this.robots.map(({ robot }) => robot.id), localMapAgents: this.robots.map(({ robot }) => robot.name),
    });
  }

  private record(message: WatchMapResponse): WatchMapResponse {
    this.past.push(message);
    return message;
  }

  private accept(a: SimulatedRobot, b: SimulatedRobot): void {
    for (let i = 0; i < 4; i++) {
      const [x, y] = nearest(a, b, i * 3);
      this.addOverlap(this.keyframeName(a, x), this.keyframeName(b, y), OverlapVerdict.ACCEPTED, '');
    }
    this.happen({ case: 'overlapAccepted', value: { localMaps: [a, b].map(({ robot }) => `localMaps/${hexId(robot.id)}`) } });
  }

  private refuse(): void {
    const [a, b] = [this.random.below(this.robots.length), this.random.below(this.robots.length)];
    const [one, other] = [this.robots[a], this.robots[b]];
    const verdict = 2 + this.random.below(7);
    const note = verdict === OverlapVerdict.BENDS_GRAPH ? 'It would move 14 keyframes by more than 3 m.' : '';
    this.addOverlap(
      this.keyframeName(one, this.random.below(one.keyframes.length)),
      this.keyframeName(other, this.random.below(other.keyframes.length)), verdict, note);
  }

  private addOverlap(query: string, candidate: string, verdict: OverlapVerdict, note: string): void {
    const isAccepted = verdict === OverlapVerdict.ACCEPTED;
    const number = BigInt(this.overlaps.length + 1);
    const reached = isAccepted ? 9 : verdict;
    // The stage that refused it has too little.
    const at = (stage: number, value: number) => (reached > stage ? value : reached === stage ? Math.floor(value / 9) : 0);
    this.overlaps.push(create(OverlapSchema, {
      query, candidate, verdict, note, number, name: `missions/${this.name}/overlaps/${number}`, fused: isAccepted,
      inliers: at(4, 61), revision: isAccepted ? this.revision + 1n : 0n,
      evidence: {
        sharedWords: 148, wordMatches: at(2, 57), ransacInliers: at(3, 31), guidedMatches: at(4, 88),
        refinedInliers: at(4, 61), projectedMatches: at(5, 122), consistentKeyframes: at(6, 4), chanceMatches: reached >= 5 ? 9 : 0, visiblePoints: reached >= 5 ? 260 : 0,
      },
    }));
  }
}

/** How many keyframes see a point: mostly few, sometimes many. */
function observationsOf(point: number): number {
  const part = ((point * 2_654_435_761) % 1000) / 1000;
  return 2 + Math.floor(-7 * Math.log(1 - part));
}

/** Two keyframes of two robots that stand near each other, away from the nearest by some steps. */
function nearest(a: SimulatedRobot, b: SimulatedRobot, away: number): [number, number] {
  let best = Infinity;
  let pair: [number, number] = [0, 0];
  a.keyframes.forEach(({ world: { centre: p } }, i) => b.keyframes.forEach(({ world: { centre: q } }, j) => {
    const distance = Math.hypot(p[0] - q[0], p[2] - q[2]);
    if (distance < best) [best, pair] = [distance, [i, j]];
  }));
  return [Math.max(0, pair[0] - away), Math.min(b.keyframes.length - 1, pair[1] + away)];
}
