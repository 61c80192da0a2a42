// Why an overlap was refused: each stage's number beside what it had to be.
import { type Overlap, type OverlapEvidence, OverlapVerdict } from '@gen/corbslam/v1/overlap_pb';
import { count } from './texts';

/** What a place has to show to be believed, as the worker has it (PlaceVerificationOptions; a test compares them). */
export const BARS = {
  wordMatches: 20, ransacInliers: 15, refinedInliers: 25, projectedMatches: 40, projectedToChance: 5,
  projectedShare: 0.1, projectedToChanceOfFew: 10, consistentKeyframes: 2, scaleDeviation: 0.05,
};

/** A count of one stage, for people. */
export interface StageRow {
  name: string;
  /** The number; of a stage that was not reached, that. */
  value: string;
  /** What it had to be at least; empty: there is no bar. */
  bar: string;
  isShort: boolean;
  isReached: boolean;
}

const NOT_REACHED = 'not reached';

/** How many stages left numbers. */
function reached({ verdict, evidence: e }: Overlap): number {
  switch (verdict) {
    case OverlapVerdict.TOO_FEW_WORD_MATCHES: return 1;
    case OverlapVerdict.TOO_FEW_RANSAC_INLIERS: return 2;
    case OverlapVerdict.WRONG_SCALE: return 3;
    // The last look at the matches refuses likewise, behind all other stages.
    case OverlapVerdict.TOO_FEW_REFINED_INLIERS: return (e?.projectedMatches ?? 0) > 0 ? 5 : 3;
    case OverlapVerdict.TOO_FEW_PROJECTED_MATCHES: return 4;
    case OverlapVerdict.UNSPECIFIED: return 0;
    default: return 5;
  }
}

/** Points that had to be found where they should be: enough, and more than chance finds. */
export function projectedBar({ projectedMatches, visiblePoints, chanceMatches }: Pick<OverlapEvidence, 'projectedMatches' | 'visiblePoints' | 'chanceMatches'>): number {
  const isFew = projectedMatches < BARS.projectedShare * visiblePoints;
  return Math.max(BARS.projectedMatches, (isFew ? BARS.projectedToChanceOfFew : BARS.projectedToChance) * chanceMatches);
}

export function stageRows(overlap: Overlap): StageRow[] {
  const e = overlap.evidence;
  if (!e) return [];
  const last = reached(overlap);
  const row = (stage: number, name: string, value: number, bar = 0): StageRow => {
    if (stage > last) return { name, value: NOT_REACHED, bar: '', isShort: false, isReached: false };
    return { name, value: count(value), bar: bar > 0 ? `of ${count(bar)} needed` : '', isShort: value < bar, isReached: true };
  };
  return [
    row(1, 'Words in common', e.sharedWords),
    row(1, 'Keypoints matched by words', e.wordMatches, BARS.wordMatches),
    row(2, '… agree with one motion', e.ransacInliers, BARS.ransacInliers),
    row(3, 'Matches of the guided search', e.guidedMatches),
    row(3, '… left after refinement', e.refinedInliers, BARS.refinedInliers),
    row(4, 'Neighbourhood points in view', e.visiblePoints),
    row(4, '… found by chance alone', e.chanceMatches),
    row(4, '… found where they should be', e.projectedMatches, projectedBar(e)),
    row(5, 'Further keyframe pairs that agree', e.consistentKeyframes, BARS.consistentKeyframes),
  ];
}

/** The number that decided, with its bar; empty: none did. */
export function decidingText(overlap: Overlap): string {
  const e = overlap.evidence;
  if (!e) return '';
  const of = (value: number, bar: number, what: string) => `${count(value)} of ${count(bar)} ${what}`;
  switch (overlap.verdict) {
    case OverlapVerdict.TOO_FEW_WORD_MATCHES: return of(e.wordMatches, BARS.wordMatches, 'keypoints look alike');
    case OverlapVerdict.TOO_FEW_RANSAC_INLIERS: return of(e.ransacInliers, BARS.ransacInliers, 'agree with one motion');
    case OverlapVerdict.TOO_FEW_REFINED_INLIERS: return e.refinedInliers < BARS.refinedInliers
      ? of(e.refinedInliers, BARS.refinedInliers, 'left after refinement') : 'the matches leave one direction open';
    case OverlapVerdict.TOO_FEW_PROJECTED_MATCHES: return of(e.projectedMatches, projectedBar(e), 'points where they should be');
    case OverlapVerdict.NO_SECOND_KEYFRAME: return of(e.consistentKeyframes, BARS.consistentKeyframes, 'further pairs agree');
    case OverlapVerdict.WRONG_SCALE: return `the scales differ by more than ${100 * BARS.scaleDeviation} %, or are not known`;
    default: return '';
  }
}
