// The question where a picture was taken in a mission's map, and its answer.
#ifndef CORBSLAM_MAP_STORE_LOCATING_LOCALIZE_QUERY_H_
#define CORBSLAM_MAP_STORE_LOCATING_LOCALIZE_QUERY_H_

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "map_store/state/lookups.h"
#include "slam/exchange/frame_location.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/keyframe.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Roughly where a picture was taken.
struct PosePrior {
  Rigid3d camera_from_global;
  double radius_m = 0;
};

struct LocalizeQuery {
  // A picture, of which a worker finds the features, or features, as a keyframe without a place
  // (LocateFrameRequest::frame); its words are not looked at.
  std::variant<ExtractFeaturesRequest, Keyframe> picture;
  // With a prior only the reference island is looked at.
  std::optional<PosePrior> prior;
  bool all_islands = false;  // Otherwise only the reference island.

  bool LooksEverywhere() const { return all_islands && !prior.has_value(); }
};

struct LocalizeAnswer {
  LocateStage stage = LocateStage::kNoCandidates;
  uint64_t revision = 0;
  // As LocateFrameResult's.
  int word_matches = 0;
  int pose_inliers = 0;
  int inliers = 0;
  int inliers_needed = 0;
  int visible_points = 0;
  int chance_inliers = 0;
  std::optional<Camera> fitting_camera;
  // These are set with kLocated.
  IslandId island;
  bool in_reference_island = false;
  Rigid3d camera_from_island;
  std::optional<Matrix6d> covariance;
  std::vector<KeyframeId> keyframes;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_LOCATING_LOCALIZE_QUERY_H_
