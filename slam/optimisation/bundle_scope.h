// Says what a bundle adjustment moves and what it holds on to.
#ifndef CORBSLAM_SLAM_OPTIMISATION_BUNDLE_SCOPE_H_
#define CORBSLAM_SLAM_OPTIMISATION_BUNDLE_SCOPE_H_

#include <vector>

#include "absl/types/span.h"
#include "slam/map/map.h"
#include "slam/util/ids.h"

namespace corbslam {

struct BundleScope {
  std::vector<KeyframeId> free_keyframes;
  std::vector<KeyframeId> fixed_keyframes;
  std::vector<MapPointId> free_points;
  std::vector<MapPointId> fixed_points;
};

// Returns the scope around `centre`, of what the keyframes of the local map `own` measure by
// themselves. Free are `centre` and its covisible keyframes (15 points or more) of `own`, and the
// points that they see: own ones, and of others' those that own keyframes locate (IsLocatedBy).
// Fixed are the other own observers of those points, and the map's root. Others' keyframes, and
// points of which they alone say where these are, take no part. Sorted by id; empty where `centre`
// is unknown. Where nothing else would be fixed, the oldest free keyframe is.
BundleScope LocalBundleScope(const Map& map, KeyframeId centre, LocalMapId own);

// Returns a scope of all keyframes and points. `fixed` are held (those unknown to the map are
// skipped); where none of them is in the map, its root is.
BundleScope GlobalBundleScope(const Map& map, absl::Span<const KeyframeId> fixed);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_BUNDLE_SCOPE_H_
