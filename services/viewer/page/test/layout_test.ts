import assert from 'node:assert/strict';
import test from 'node:test';
import { alignPoses } from '../src/model/alignment';
import { layOut } from '../src/model/layout';
import { type Pose } from '../src/model/pose';
import { type Quat, type Vec3, multiply, rotate } from '../src/model/vector';

const box = (size: number) => ({ minX: 0, maxX: size, minZ: 0, maxZ: size });

test('islands stand apart, the reference at the origin', () => {
  const plots = layOut([{ name: 'b', isReference: false, box: box(10) }, { name: 'a', isReference: true, box: box(50) }], new Map());
  assert.equal(plots.get('a')?.offsetX, 0);
  const [a, b] = [plots.get('a')!, plots.get('b')!];
  assert.ok(b.offsetX + 0 > a.maxX, 'B begins behind A');
});

test('nothing moves while every island fits', () => {
  const islands = (size: number) => [{ name: 'a', isReference: true, box: box(size) }, { name: 'b', isReference: false, box: box(10) }];
  const plots = layOut(islands(50), new Map());
  assert.deepEqual(layOut(islands(55), plots), plots);
  assert.notDeepEqual(layOut(islands(90), plots), plots);
});

test('an alignment of a straight path is found with its turn and scale', () => {
  const turn: Quat = [0, Math.sin(0.4), 0, Math.cos(0.4)];
  const source: Pose[] = [0, 1, 2].map((x) => ({ centre: [x, 0, 0] as Vec3, rotation: [0, 0, 0, 1] as Quat }));
  const target = source.map(({ centre, rotation }) => {
    const turned = rotate(turn, centre);
    return { centre: [2 * turned[0] + 5, 2 * turned[1], 2 * turned[2]] as Vec3, rotation: multiply(turn, rotation) };
  });
  const found = alignPoses(source, target)!;
  assert.ok(Math.abs(found.scale - 2) < 1e-9);
  found.rotation.forEach((value, i) => assert.ok(Math.abs(value - turn[i]) < 1e-9));
  found.translation.forEach((value, i) => assert.ok(Math.abs(value - [5, 0, 0][i]) < 1e-9));
});

test('islands of a room stand a few metres apart, paths alone closer still', () => {
  const islands = ['a', 'b'].map((name) => ({ name, isReference: name === 'a', box: box(0.5) }));
  const apart = (hasPoints: boolean) => layOut(islands, new Map(), hasPoints).get('b')!.offsetX;
  assert.ok(apart(true) > 4 && apart(true) < 10, String(apart(true)));
  assert.ok(apart(false) < 2.5, String(apart(false)));
});
