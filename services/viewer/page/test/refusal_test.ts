import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import test from 'node:test';
import { create } from '@bufbuild/protobuf';
import { OverlapSchema, OverlapVerdict } from '@gen/corbslam/v1/overlap_pb';
import { BARS, decidingText, projectedBar, stageRows } from '../src/model/refusal';

const overlap = (verdict: OverlapVerdict, evidence: object) => create(OverlapSchema, { verdict, evidence });
const said = (verdict: OverlapVerdict, evidence: object) =>
  Object.fromEntries(stageRows(overlap(verdict, evidence)).map(({ name, value, bar, isShort }) => [name, `${value} ${bar}${isShort ? ' !' : ''}`.trim()]));

test('a refusal has its number, none being one, and what was needed', () => {
  const rows = said(OverlapVerdict.TOO_FEW_RANSAC_INLIERS, { sharedWords: 90, wordMatches: 33, ransacInliers: 0 });
  assert.equal(rows['Keypoints matched by words'], '33 of 20 needed');
  assert.equal(rows['… agree with one motion'], '0 of 15 needed !');
  assert.equal(rows['… left after refinement'], 'not reached');
  assert.equal(decidingText(overlap(OverlapVerdict.TOO_FEW_WORD_MATCHES, { wordMatches: 0 })), '0 of 20 keypoints look alike');
  assert.equal(decidingText(overlap(OverlapVerdict.NO_SECOND_KEYFRAME, { consistentKeyframes: 1 })), '1 of 2 further pairs agree');
});

test('the bar of points where they should be follows what chance finds', () => {
  assert.equal(projectedBar({ projectedMatches: 30, visiblePoints: 200, chanceMatches: 3 }), 40);
  assert.equal(projectedBar({ projectedMatches: 60, visiblePoints: 200, chanceMatches: 13 }), 65);
  assert.equal(projectedBar({ projectedMatches: 45, visiblePoints: 600, chanceMatches: 7 }), 70, 'little of what should be seen');
  const rows = said(OverlapVerdict.TOO_FEW_PROJECTED_MATCHES, { wordMatches: 50, ransacInliers: 30, refinedInliers: 40, projectedMatches: 60, visiblePoints: 200, chanceMatches: 13 });
  assert.equal(rows['… found where they should be'], '60 of 65 needed !');
  assert.equal(rows['Further keyframe pairs that agree'], 'not reached');
});

test('an accepted overlap has all its numbers', () => {
  const rows = said(OverlapVerdict.ACCEPTED, { wordMatches: 50, ransacInliers: 30, refinedInliers: 40, projectedMatches: 90, visiblePoints: 200, chanceMatches: 3, consistentKeyframes: 4 });
  assert.ok(Object.values(rows).every((words) => !/not reached|!/.test(words)), JSON.stringify(rows));
});

test('the bars are the worker’s', () => {
  const header = readFileSync(join(process.cwd(), '../../../slam/verification/place_verification.h'), 'utf8');
  const value = (name: string) => Number(new RegExp(`${name} = ([0-9.]+);`).exec(header)?.[1]);
  const names: Record<keyof typeof BARS, string> = {
    wordMatches: 'min_word_matches', ransacInliers: 'min_ransac_inliers', refinedInliers: 'min_refined_inliers',
    projectedMatches: 'min_projected_matches', projectedToChance: 'min_projected_to_chance', projectedShare: 'min_projected_share',
    projectedToChanceOfFew: 'min_projected_to_chance_of_few', consistentKeyframes: 'min_consistent_keyframes', scaleDeviation: 'max_scale_deviation',
  };
  for (const [key, name] of Object.entries(names)) assert.equal(BARS[key as keyof typeof BARS], value(name), name);
});
