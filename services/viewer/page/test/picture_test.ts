import assert from 'node:assert/strict';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { FeaturesSchema } from '@gen/corbslam/v1/items_pb';
import { OverlapSchema, OverlapVerdict } from '@gen/corbslam/v1/overlap_pb';
import { arrange, boundsOf, fit, fullSize, placeIn, some } from '../src/model/picture';
import { matchesText, missingText } from '../src/panels/seen_overlap';

test('a keypoint lies in a small picture where it lay in the camera’s', () => {
  const full = fullSize({ width: 320, height: 240 }, 2);
  assert.deepEqual(full, { width: 640, height: 480 });
  const box = { x: 10, y: 20, width: 320, height: 240 };
  // The middle of the first pixel is half a pixel from the edge, whatever the size.
  assert.deepEqual(placeIn(box, full, { x: 0, y: 0 }), { x: 10.25, y: 20.25 });
  assert.deepEqual(placeIn(box, full, { x: 639, y: 479 }), { x: 329.75, y: 259.75 });
});

test('wide pictures lie one below the other, high ones side by side', () => {
  const wide = { width: 1241, height: 376 };
  const below = arrange(wide, wide, { width: 286, height: 300 }, 6);
  assert.equal(below.second.x, 0);
  assert.ok(Math.abs(below.first.width - 286) < 1e-9 && below.second.y === below.first.height + 6);
  const beside = arrange({ width: 480, height: 640 }, { width: 480, height: 640 }, { width: 286, height: 300 }, 6);
  assert.equal(beside.second.y, 0);
  assert.ok(beside.size.width <= 286 && beside.size.height <= 300);
});

test('two cameras’ pictures of different sizes fit into their halves', () => {
  const { first, second, size } = arrange({ width: 1241, height: 376 }, { width: 640, height: 480 }, { width: 400, height: 300 }, 4);
  for (const box of [first, second]) assert.ok(box.x + box.width <= size.width + 1e-9 && box.y + box.height <= size.height + 1e-9);
  assert.deepEqual(fit({ width: 100, height: 50 }, { width: 200, height: 50 }), { width: 100, height: 50 });
});

test('of many matches some are drawn, evenly', () => {
  assert.deepEqual(some([1, 2, 3], 5), [1, 2, 3]);
  assert.deepEqual(some([0, 1, 2, 3, 4, 5, 6, 7], 4), [0, 2, 4, 6]);
});

test('a picture that is not there has the size of its keypoints', () => {
  assert.deepEqual(boundsOf([{ x: 100, y: 20 }, { x: 30, y: 60 }]), { width: 116, height: 76 });
  assert.deepEqual(boundsOf([]), { width: 640, height: 480 });
});

test('what the lines mean is said by the verdict', () => {
  const match = { queryXPx: 1, queryYPx: 2, candidateXPx: 3, candidateYPx: 4 };
  const words = (verdict: OverlapVerdict, matches: object[]) => matchesText({ overlap: create(OverlapSchema, { verdict, matches }) });
  assert.match(words(OverlapVerdict.ACCEPTED, [match]), /^1 pair of keypoints shows the same;/);
  assert.match(words(OverlapVerdict.ACCEPTED, Array.from({ length: 60 }, () => match)), /^60 pairs .* show the same, of which some/);
  assert.match(words(OverlapVerdict.WRONG_SCALE, [match, match]), /^2 pairs of keypoints look alike, by themselves;/);
  assert.match(words(OverlapVerdict.ACCEPTED, []), /^No keypoints of the two show the same any more/);
});

test('why a picture is missing is said once where it is the same for both', () => {
  const features = create(FeaturesSchema);
  const side = (why: string) => ({ shown: { why }, features });
  assert.equal(missingText(side('gone'), side('gone')), 'gone');
  assert.equal(missingText(side('gone'), side('never sent')), 'Asked: gone Candidate: never sent');
});
