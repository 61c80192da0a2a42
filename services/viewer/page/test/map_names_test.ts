import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { MissionPulseSchema } from '@gen/corbslam/v1/viewer_pb';
import { MapNames } from '../src/model/map_names';

const ID = ['0000000000000001', '0000000000000002', '0000000000000003'];
const told = (...localMaps: { id: string; number: number; parts?: [string, number][] }[]) => create(MissionPulseSchema, {
  localMaps: localMaps.map(({ id, number, parts = [] }) => ({
    name: `missions/m/localMaps/${id}`, agent: 'missions/m/agents/alpha', number,
    joinedLocalMaps: parts.map(([part]) => `missions/m/localMaps/${part}`), joinedNumbers: parts.map(([, ofPart]) => ofPart),
  })),
});

test('local maps are called after their robots', () => {
  const names = new MapNames();
  assert.equal(names.of(ID[0]), 'map 0000');
  names.learn(told({ id: ID[0], number: 1 }, { id: ID[1], number: 2 }));
  assert.equal(names.of(ID[1]), 'alpha’s map 2');
  assert.equal(names.ownOf(ID[1]), 'map 2');
});

test('the number is the one that the store gave, though an earlier local map be deleted', () => {
  const names = new MapNames();
  names.learn(told({ id: ID[1], number: 2 }));
  assert.equal(names.of(ID[1]), 'alpha’s map 2');
  const { version } = names;
  names.learn(told({ id: ID[1], number: 2 }));
  assert.equal(names.version, version, 'an unchanged pulse changes nothing');
});

test('a session that became part of another one keeps its number', () => {
  const names = new MapNames();
  names.learn(told({ id: ID[0], number: 1, parts: [[ID[2], 3]] }));
  assert.equal(names.of(ID[2]), 'alpha’s map 3');
});

test('a keyframe of one of several sessions is told apart from those of the others', () => {
  const names = new MapNames();
  names.learn(told({ id: ID[0], number: 1 }));
  assert.equal(names.keyframe(`missions/m/localMaps/${ID[0]}/keyframes/0`), 'alpha #0');
  names.learn(told({ id: ID[0], number: 1 }, { id: ID[1], number: 2 }));
  assert.equal(names.keyframe(`missions/m/localMaps/${ID[0]}/keyframes/0`), 'alpha’s map 1 #0');
  assert.equal(names.keyframe(`missions/m/localMaps/${ID[1]}/keyframes/0`), 'alpha’s map 2 #0');
  assert.equal(names.keyframe('nothing of the kind'), 'nothing of the kind');
});
