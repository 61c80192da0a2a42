// What the simulated server answers to requests, by the contract of the page.
import { type DescMessage, type MessageInitShape, create, toBinary, toJsonString } from '@bufbuild/protobuf';
import { GetTrajectoryResponseSchema, ListMissionsResponseSchema, ListOverlapsResponseSchema, WatchMapResponseSchema } from '@gen/corbslam/v1/map_store_service_pb';
import { OverlapMatchSchema, OverlapSchema, OverlapVerdict } from '@gen/corbslam/v1/overlap_pb';
import { AgentActivity, KeyframeSchema } from '@gen/corbslam/v1/resources_pb';
import { MissionPulseSchema, type MissionPulse } from '@gen/corbslam/v1/viewer_pb';
import { TrackingState } from '@gen/corbslam/v1/agent_service_pb';
import { hexId } from '../src/model/ids';
import { Random } from '../src/model/random';
import type { Quat, Vec3 } from '../src/model/vector';
import { picture } from './picture';
import { cameraFromFrame, toOwnFrame, turnToOwnFrame } from './street';
import { type SimulatedMission, type SimulatedRobot, isLeft, now } from './simulated_mission';

export type Answer = { type: string; body: Uint8Array | string; headers?: Record<string, string> } | undefined;

function json<S extends DescMessage>(schema: S, init: MessageInitShape<S>): Answer {
  return { type: 'application/json', body: toJsonString(schema, create(schema, init), { alwaysEmitImplicit: true }) };
}

export function missionFacts(mission: SimulatedMission) {
  const { robots } = mission;
  return {
    name: `missions/${mission.name}`, revision: mission.revision, agents: robots.length, localMaps: robots.length,
    islands: new Set(robots.map(({ island }) => island)).size, fusionIdle: false, waitingQueries: 17n,
    createdNs: now() - 90_000_000_000_000n, lastUsedNs: now() - 60_000_000_000n, connectedAgents: 2, description: 'The car park, with the hall',
    keyframes: BigInt(robots.reduce((sum, { keyframes }) => sum + keyframes.length, 0)),
    mapPoints: BigInt(robots.reduce((sum, { points }) => sum + points.length, 0)),
  };
}

export function listMissions(missions: SimulatedMission[]): Answer {
  return json(ListMissionsResponseSchema, { missions: missions.map(missionFacts) });
}

export function answer(mission: SimulatedMission, path: string, query: URLSearchParams): Answer {
  if (path === '/overlaps') {
    const all = query.get('acceptedOnly') !== 'true';
    return json(ListOverlapsResponseSchema, {
      overlaps: mission.overlaps.filter(({ verdict }) => all || verdict === OverlapVerdict.ACCEPTED),
    });
  }
  const overlap = /^\/overlaps\/(\d+)$/.exec(path);
  if (overlap) return oneOverlap(mission, BigInt(overlap[1]));
  const seen = /^\/localMaps\/[0-9a-f]{16}\/keyframes\/(\d+)\/picture$/.exec(path);
  if (seen) return Number(seen[1]) % 5 === 4 ? { type: 'text/plain', body: '' } : picture(Number(seen[1]));
  if (path === '/trajectory') return trajectory(mission, query.get('frame') === 'local');
  if (path === '/truth') return { type: 'text/plain', body: truth(mission) };
  if (path === '/history') return prefixed(mission.past.map((message) => toBinary(WatchMapResponseSchema, message)));
  const match = /^\/localMaps\/([0-9a-f]{16})\/keyframes\/(\d+)$/.exec(path);
  return match ? keyframe(mission, match[1], Number(match[2])) : undefined;
}

/** With made-up matches: what is the same lies a little further right in the candidate. */
function oneOverlap(mission: SimulatedMission, number: bigint): Answer {
  const found = mission.overlaps.find((one) => one.number === number);
  if (!found) return undefined;
  const random = new Random(Number(number) + 5);
  const matches = Array.from({ length: found.verdict === OverlapVerdict.ACCEPTED ? 160 : 12 }, () => {
    const [x, y] = [50 + random.below(1000), 60 + random.below(250)];
    return { queryXPx: x, queryYPx: y, candidateXPx: x + 60 + random.below(20), candidateYPx: y + random.below(12) };
  });
  return json(OverlapSchema, { ...found, matches: matches.map((match) => create(OverlapMatchSchema, match)) });
}

/** Where the first robot really was: beside where it says, as far as it has come. */
function truth({ robots: [first] }: SimulatedMission): string {
  return first.keyframes.map(({ world: { centre: [x, y, z], rotation }, timeNs }) =>
    [Number(timeNs) / 1e9, x + Math.sin(x / 20), y, z, ...rotation].join(' ')).join('\n');
}

function prefixed(messages: Uint8Array[]): Answer {
  const parts = messages.flatMap((message) => {
    const length = Buffer.alloc(4);
    length.writeUInt32LE(message.length);
    return [length, message];
  });
  return { type: 'application/octet-stream', body: Buffer.concat(parts) };
}

function trajectory(mission: SimulatedMission, isLocal: boolean): Answer {
  const messages = mission.robots.map((one) => {
    const frame = isLocal ? one.robot : mission.robots[one.island].robot;
    const poses = one.keyframes.map(({ world, timeNs }) => {
      const [x, y, z, w] = turnToOwnFrame(frame, world.rotation);
      const wobble = Math.sin(Number(timeNs) / 1e9) * 0.2;
      const centre = toOwnFrame(frame, world.centre);
      return {
        agent: `missions/${mission.name}/agents/${one.robot.name}`, timestampNs: timeNs,
        localMap: `missions/${mission.name}/localMaps/${hexId(one.robot.id)}`,
        island: isLocal ? '' : `missions/${mission.name}/localMaps/${hexId(mission.robots[one.island].robot.id)}`,
        frameFromCamera: { rotationWxyz: [w, x, y, z], translation: [centre[0] + wobble, centre[1], centre[2]] },
      };
    });
    return toBinary(GetTrajectoryResponseSchema, create(GetTrajectoryResponseSchema, { revision: mission.revision, poses }));
  });
  return prefixed(isLocal || !mission.hasLocaliser ? messages : [...messages, localised(mission)]);
}

/** Where a robot that only localises is: beside the first robot's way, back and forth. */
function localiserAt({ robots: [first] }: SimulatedMission, step: number): Vec3 {
  const all = first.keyframes.length - 1;
  const at = Math.abs(((step + all) % (2 * all)) - all);
  const [x, y, z] = toOwnFrame(first.robot, first.keyframes[at].world.centre);
  return [x + 4, y, z + 4];
}

function localised(mission: SimulatedMission): Uint8Array {
  const poses = Array.from({ length: 40 }, (_, i) => ({
    agent: `missions/${mission.name}/agents/lima`, timestampNs: BigInt(i), run: 77n, island: `missions/${mission.name}/localMaps/${hexId(mission.robots[0].robot.id)}`,
    frameFromCamera: { rotationWxyz: [1, 0, 0, 0], translation: localiserAt(mission, i) }, afterGap: i === 20,
  }));
  return toBinary(GetTrajectoryResponseSchema, create(GetTrajectoryResponseSchema, { revision: mission.revision, poses }));
}

function keyframe(mission: SimulatedMission, id: string, index: number): Answer {
  const one = mission.robots.find(({ robot }) => hexId(robot.id) === id);
  const told = one?.keyframes[index];
  if (!one || !told) return undefined;
  const random = new Random(index + 11);
  const pose = mission.pose(one, told);
  const column = (value: () => number) => Array.from({ length: 900 }, value);
  return json(KeyframeSchema, {
    name: mission.keyframeName(one, index), agent: `missions/${mission.name}/agents/${one.robot.name}`,
    timestampNs: told.timeNs, island: `localMaps/${hexId(mission.robots[one.island].robot.id)}`, placed: one.island === 0,
    settled: index < one.keyframes.length - 4, revision: mission.revision, keypoints: 900, observedPoints: 412,
    parent: index > 0 ? mission.keyframeName(one, index - 1) : '',
    sights: mission.isOld ? [] : sights(one, mission.pointsPerKeyframe, index),
    cameraFromLocal: cameraFromFrame(...local(one, index)),
    cameraFromIsland: { ...cameraFromFrame(pose.centre, pose.rotation), scale: 1 },
    payload: {
      timestampNs: told.timeNs,
      features: {
        xPx64: column(() => random.below(1226 * 64)), yPx64: column(() => 40 * 64 + random.below(300 * 64)),
        disparityPx128: column(() => (random.below(3) > 0 ? 100 + random.below(5000) : 0)),
        angleTurn14: column(() => random.below(16384)), octaves: Uint8Array.from(column(() => random.below(8))),
      },
    },
  });
}

function asked({ robots: [first] }: SimulatedMission) {
  const { tracked, frames, newestFrameAgeS } = reportOf(0);
  return { tracked, frames, newestFrameAgeS, mapPoints: BigInt(first.points.length) };
}

/** It sees what came with it and the keyframes before; three points are of a local map that nobody has. */
function sights({ robot, points }: SimulatedRobot, each: number, index: number) {
  const from = Math.max(0, (index - 6) * each);
  const count = Math.min(412, points.length - from);
  return Array.from({ length: count }, (_, i) => ({
    keypoint: 2 * i, localMap: i < 3 ? 5n : robot.id, point: from + i,
  }));
}

/** Where the robot itself thinks that it was: 1 per cent too far. */
function local({ robot, keyframes }: SimulatedRobot, index: number): [Vec3, Quat] {
  const { centre, rotation } = keyframes[index].world;
  const [x, y, z] = toOwnFrame(robot, centre);
  return [[1.01 * x, 1.01 * y, 1.01 * z], turnToOwnFrame(robot, rotation)];
}

const begunMs = Date.now();
const ACTIVITIES = [AgentActivity.TRACKING, AgentActivity.LOST, AgentActivity.FINISHED];

function reportOf(i: number) {
  const seconds = (Date.now() - begunMs) / 1000;
  const frames = BigInt(Math.round(10 * seconds + 5 * Math.sin(seconds / 5)));
  return { activity: ACTIVITIES[i % 3], frames: 100n + frames, tracked: 90n + frames, lost: 10n, newestFrameAgeS: 0.12 + 0.05 * Math.sin(seconds / 3) };
}

/** The third robot's map is larger than what the second one's camera measures. */
function contradictions({ robots }: SimulatedMission, i: number) {
  return i === 1 && robots.length > 2 ? [{ localMap: robots[2].robot.id, scale: 1.0141, scaleSigma: 0.0016 }] : [];
}

function localiser(mission: SimulatedMission, name: string) {
  const at = localiserAt(mission, Math.floor((Date.now() - begunMs) / 1000));
  return {
    name, connected: true, localiseOnly: true, reportAgeS: 1, report: reportOf(0),
    lastPose: { timestampNs: now(), island: `localMaps/${hexId(mission.robots[0].robot.id)}`, inGlobalFrame: true, cameraFromIsland: cameraFromFrame(at, [0, 0, 0, 1]) },
  };
}

export function pulse(mission: SimulatedMission, storeAnswers: boolean): MissionPulse {
  const facts = missionFacts(mission);
  const name = (robot: string) => `missions/${mission.name}/agents/${robot}`;
  return create(MissionPulseSchema, {
    timeNs: now(), storeAnswers, storeError: storeAnswers ? '' : 'connection refused', mission: facts,
    agents: mission.robots.map(({ robot }, i) => ({
      name: name(robot.name), connected: i !== 2, localMaps: [`localMaps/${hexId(robot.id)}`], upToDate: i === 0,
      ...(mission.isOld ? {} : { leftOnPurpose: i === 2, reportAgeS: 1, report: { ...reportOf(i), contradictions: contradictions(mission, i) } }),
    })).concat(mission.hasLocaliser ? [localiser(mission, name('lima')) as never] : []),
    localMaps: mission.robots.map(({ robot, keyframes, isThinned }) => ({
      name: `localMaps/${hexId(robot.id)}`, agent: name(robot.name), number: 1, keyframes: BigInt(keyframes.length), lostFrames: 12n,
      ...(isThinned ? { closed: true, retiredKeyframes: BigInt(keyframes.filter((_, k) => !isLeft(k)).length), fadedMapPoints: 411n } : {}),
    })),
    statistics: {
      revision: mission.revision, overlapsQueried: 812n, overlapsVerified: BigInt(mission.overlaps.length),
      overlapsAccepted: BigInt(mission.overlaps.filter(({ verdict }) => verdict === OverlapVerdict.ACCEPTED).length),
    },
    robots: [
      { agent: name(mission.robots[0].robot.name), status: { state: TrackingState.TRACKING, ...asked(mission), outboxBatches: 2n, outboxMemoryBytes: 48_213n } },
      { agent: name(mission.robots[1].robot.name), status: { state: TrackingState.LOST, sessionMessage: 'another process of this name is connected' } },
    ],
  });
}
