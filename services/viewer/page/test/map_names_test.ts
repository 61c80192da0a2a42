import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { MissionPulseSchema } from '@gen/corbslam/v1/viewer_pb';
import { MapNames } from '../src/model/map_names';

const ID = ['0000000000000001', '0000000000000002', '0000000000000003'];
const told = (localMaps: string[]) => create(MissionPulseSchema, {
  agents: [{ name: 'missions/m/agents/alpha', localMaps: localMaps.map((id) => `missions/m/localMaps/${id}`) }],
});

test('local maps are called after their robots', () => {
  const names = new MapNames();
  assert.equal(names.of(ID[0]), 'map 0000');
  names.learn(told([ID[0], ID[1]]));
  assert.equal(names.of(ID[1]), 'alpha’s map 2');
  assert.equal(names.ownOf(ID[1]), 'map 2');
});

test('a name stays though an earlier local map goes, and an unchanged pulse changes nothing', () => {
  const names = new MapNames();
  names.learn(told([ID[0], ID[1]]));
  const { version } = names;
  names.learn(told([ID[1]]));
  assert.equal(names.of(ID[1]), 'alpha’s map 2');
  assert.equal(names.version, version);
});

test('a session that became part of another one is its robot’s', () => {
  const names = new MapNames();
  names.learn(create(MissionPulseSchema, {
    localMaps: [{ name: `l/${ID[0]}`, agent: 'a/beta', joinedLocalMaps: [`l/${ID[2]}`] }],
  }));
  assert.equal(names.of(ID[2]), 'beta’s map 0000');
});

test('a keyframe of one of several sessions is told apart from those of the others', () => {
  const names = new MapNames();
  names.learn(told([ID[0]]));
  assert.equal(names.keyframe(`missions/m/localMaps/${ID[0]}/keyframes/0`), 'alpha #0');
  names.learn(told([ID[0], ID[1]]));
  assert.equal(names.keyframe(`missions/m/localMaps/${ID[0]}/keyframes/0`), 'alpha’s map 1 #0');
  assert.equal(names.keyframe(`missions/m/localMaps/${ID[1]}/keyframes/0`), 'alpha’s map 2 #0');
  assert.equal(names.keyframe('nothing of the kind'), 'nothing of the kind');
});
