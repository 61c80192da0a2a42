// A simulated town: robots drive loops through its streets and see points on the houses.
import { Random } from '../src/model/random';
import { type Quat, type Vec3, conjugate, multiply, rotate } from '../src/model/vector';

export interface StreetKeyframe {
  centre: Vec3;
  rotation: Quat;
}

export interface Robot {
  name: string;
  id: bigint;
  /** local_from_world of this robot's own frame. */
  turn: Quat;
  shift: Vec3;
  corners: [number, number][];
}

function about(yaw: number): Quat {
  return [0, Math.sin(yaw / 2), 0, Math.cos(yaw / 2)];
}

/** Robots whose loops share streets, each with a frame of its own. */
export function makeRobots(count: number, random: Random): Robot[] {
  const names = ['alpha', 'beta', 'gamma', 'delta', 'epsilon', 'zeta', 'eta', 'theta'];
  return Array.from({ length: count }, (_, i) => {
    const [x, z] = [(i % 3) * 70, Math.floor(i / 3) * 90];
    return {
      name: names[i % names.length],
      id: (BigInt(random.below(2 ** 31)) << 32n) | BigInt(random.below(2 ** 31)),
      turn: about(i === 0 ? 0 : 0.7 + i),
      shift: [i === 0 ? 0 : -20 * i, 0, 11 * i] as Vec3,
      corners: [[x, z], [x + 90, z], [x + 90, z + 110], [x + 20, z + 110], [x, z + 60]] as [number, number][],
    };
  });
}

/** The camera at a distance along the loop, in the world's frame. */
export function driveTo({ corners }: Robot, distance: number): StreetKeyframe {
  let rest = distance;
  for (let i = 0; ; i = (i + 1) % corners.length) {
    const [a, b] = [corners[i], corners[(i + 1) % corners.length]];
    const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
    if (rest > length) {
      rest -= length;
      continue;
    }
    const [dx, dz] = [(b[0] - a[0]) / length, (b[1] - a[1]) / length];
    const sway = 0.4 * Math.sin(distance / 7);
    return {
      centre: [a[0] + dx * rest + dz * sway, 0.15 * Math.sin(distance / 11), a[1] + dz * rest - dx * sway],
      rotation: about(Math.atan2(dx, dz)),
    };
  }
}

/** A point on a house, the road or a tree, seen from a camera; y is down. */
export function seePoint({ centre, rotation }: StreetKeyframe, random: Random): Vec3 {
  const side = random.below(2) === 0 ? -1 : 1;
  const kind = random.below(10);
  const ahead = 2 + random.below(1000) / 60;
  const wall = side * (7 + (kind > 7 ? random.below(100) / 40 : random.below(10) / 30));
  const local: Vec3 = kind < 2
    ? [side * random.below(60) / 10, 1.6, ahead]
    : [kind === 9 ? side * (4.5 + random.below(20) / 10) : wall, 1.6 - random.below(kind === 9 ? 40 : 75) / 10, ahead];
  const turned = rotate(rotation, local);
  return [centre[0] + turned[0], centre[1] + turned[1], centre[2] + turned[2]];
}

/** The world as a robot's own frame has it. */
export function toOwnFrame(robot: Robot, point: Vec3): Vec3 {
  const turned = rotate(robot.turn, point);
  return [turned[0] + robot.shift[0], turned[1] + robot.shift[1], turned[2] + robot.shift[2]];
}

export function turnToOwnFrame(robot: Robot, rotation: Quat): Quat {
  return multiply(robot.turn, rotation);
}

/** camera_from_frame as the wire has it. */
export function cameraFromFrame(centre: Vec3, rotation: Quat): { rotationWxyz: number[]; translation: number[] } {
  const inverse = conjugate(rotation);
  const [x, y, z] = rotate(inverse, centre);
  return { rotationWxyz: [inverse[3], inverse[0], inverse[1], inverse[2]], translation: [-x, -y, -z] };
}
