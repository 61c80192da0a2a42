import assert from 'node:assert/strict';
import test from 'node:test';
import { formatState, parseState } from '../src/view_state';

test('a link keeps the mission, the camera, what is selected and the moment', () => {
  const link = '#mission=lab&size=2.5&camera=1.5,0,-20,4,30,7.25&chosen=localMaps/00000000000000aa/keyframes/7&at=12.340';
  const state = parseState(link);
  assert.deepEqual(state.camera, [1.5, 0, -20, 4, 30, 7.25]);
  assert.equal(state.chosen, 'localMaps/00000000000000aa/keyframes/7');
  assert.equal(formatState(state), link);
  assert.equal(formatState(parseState('#mission=lab')), '#mission=lab');
});

test('what a link can’t mean is passed over', () => {
  for (const camera of ['1,2,3', '1,2,3,1,2,3', 'NaN,0,0,1,1,1', '1e99,0,0,1,1,1', '0,0,0,Infinity,0,0', ',,,,,', 'a,b,c,d,e,f', '']) {
    assert.deepEqual(parseState(`#mission=lab&camera=${camera}`).camera, [], camera);
  }
  for (const chosen of ['<img src=x>', 'localMaps/zz/keyframes/1', 'overlaps/', `overlaps/${'9'.repeat(40)}`, '../../api']) {
    assert.equal(parseState(`#mission=lab&chosen=${encodeURIComponent(chosen)}`).chosen, '', chosen);
  }
  for (const at of ['12', '-1.2', '1.2.3', 'x.y', `${'9'.repeat(30)}.1`]) assert.equal(parseState(`#mission=lab&at=${at}`).at, '', at);
  for (const size of ['0', '-3', '1e9', 'NaN', '']) assert.equal(parseState(`#mission=lab&size=${size}`).size, 1.5, size);
});
