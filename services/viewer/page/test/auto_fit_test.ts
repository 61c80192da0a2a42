import assert from 'node:assert/strict';
import test from 'node:test';
import { Box3, Vector3 } from 'three';
import { AutoFit } from '../src/auto_fit';

const box = (from: number, to: number) => new Box3(new Vector3(from, 0, 0), new Vector3(to, 1, 1));

test('a map that grows out of sight, or shrinks when islands become one, is shown anew', () => {
  const fit = new AutoFit();
  fit.begin(box(0, 100));
  let now = 10_000;
  const isDue = (extent: Box3) => fit.isDue(() => extent, (now += 2000));
  assert.equal(isDue(box(0, 102)), false);
  assert.equal(isDue(box(0, 150)), true, 'it grew');
  assert.equal(isDue(box(0, 20)), true, 'it shrank');
  assert.equal(isDue(box(60, 160)), true, 'it went aside');
  assert.equal(isDue(new Box3()), false, 'there is nothing');
});

test('who moved the camera is left alone until they ask for all', () => {
  const fit = new AutoFit();
  fit.begin(box(0, 10));
  fit.stop();
  assert.equal(fit.isDue(() => assert.fail('asked'), 5000), false);
  fit.begin(box(0, 10));
  assert.equal(fit.isDue(() => box(0, 100), 10_000), true);
  assert.equal(fit.isDue(() => assert.fail('asked too soon'), 10_500), false);
});
