#include "slam/exchange/frame_location.h"

namespace corbslam {

std::string ToString(LocateStage stage) {
  switch (stage) {
    case LocateStage::kFewFeatures:
      return "FEW_FEATURES";
    case LocateStage::kNoCandidates:
      return "NO_CANDIDATES";
    case LocateStage::kFewMatches:
      return "FEW_MATCHES";
    case LocateStage::kNoPose:
      return "NO_POSE";
    case LocateStage::kFewInliers:
      return "FEW_INLIERS";
    case LocateStage::kCameraInDoubt:
      return "CAMERA_IN_DOUBT";
    case LocateStage::kOutsidePrior:
      return "OUTSIDE_PRIOR";
    case LocateStage::kLocated:
      return "LOCATED";
  }
  return "UNKNOWN";
}

}  // namespace corbslam
