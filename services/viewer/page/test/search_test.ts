import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { MissionPulseSchema } from '@gen/corbslam/v1/viewer_pb';
import { MapModel } from '../src/model/map_model';
import { MapNames } from '../src/model/map_names';
import { search } from '../src/model/search';
import { HEX_A, HEX_B, change, keyframe } from './messages';

const model = new MapModel();
model.apply([change({ islands: [{ slot: 1, localMapSlots: [1, 2], keyframes: [keyframe(1, 12, 0), keyframe(2, 12, 5), keyframe(2, 7, 6)] }] })]);
const names = new MapNames();
names.learn(create(MissionPulseSchema, {
  localMaps: [
    { name: `l/${HEX_A}`, agent: 'missions/m/agents/alpha', number: 1 },
    { name: 'l/0000000000000001', agent: 'missions/m/agents/beta', number: 1 }, { name: `l/${HEX_B}`, agent: 'missions/m/agents/beta', number: 2 },
  ],
}));
const overlaps = [{ number: 12n, query: `localMaps/${HEX_A}/keyframes/12`, candidate: `localMaps/${HEX_B}/keyframes/7` }];
const found = (text: string) => search(text, { robots: ['alpha', 'beta'], model, names, overlaps }).map((one) => `${one.kind}: ${one.text}`);

test('robots, keyframes, local maps and overlaps are found by what people call them', () => {
  assert.deepEqual(found('alpha #12'), ['keyframe: alpha #12']);
  assert.deepEqual(found('#12'), ['keyframe: alpha #12', 'keyframe: beta’s map 2 #12']);
  assert.deepEqual(found('overlap 12'), ['overlap: Overlap 12: alpha #12 – beta’s map 2 #7']);
  assert.deepEqual(found('12').map((text) => text.split(':')[0]), ['overlap', 'keyframe', 'keyframe']);
  assert.ok(found("beta's map 2").some((text) => text.startsWith('map: beta’s map 2')));
  assert.ok(found('bet').includes('robot: beta'));
});

test('nothing is found for nothing, and for what is not there', () => {
  for (const text of ['', '   ', '#99', 'overlap 13', 'zulu', '(', '\\', `#${'9'.repeat(50)}`, '.*']) assert.deepEqual(found(text), [], text);
});
