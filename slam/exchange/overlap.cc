#include "slam/exchange/overlap.h"

namespace corbslam {

std::string ToString(OverlapVerdict verdict) {
  switch (verdict) {
    case OverlapVerdict::kAccepted:
      return "ACCEPTED";
    case OverlapVerdict::kTooFewWordMatches:
      return "TOO_FEW_WORD_MATCHES";
    case OverlapVerdict::kTooFewRansacInliers:
      return "TOO_FEW_RANSAC_INLIERS";
    case OverlapVerdict::kTooFewRefinedInliers:
      return "TOO_FEW_REFINED_INLIERS";
    case OverlapVerdict::kTooFewProjectedMatches:
      return "TOO_FEW_PROJECTED_MATCHES";
    case OverlapVerdict::kNoSecondKeyframe:
      return "NO_SECOND_KEYFRAME";
    case OverlapVerdict::kWrongScale:
      return "WRONG_SCALE";
    case OverlapVerdict::kBendsGraph:
      return "BENDS_GRAPH";
    case OverlapVerdict::kTakenBack:
      return "TAKEN_BACK";
  }
  return "UNKNOWN";
}

}  // namespace corbslam
