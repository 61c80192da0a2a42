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

// Returns the scope around `centre`: free are `centre` and its covisible keyframes (15 points or
// more) of the local map `own`, and `own` points that they see. Fixed are the other observers of
// those points, every keyframe and point of another local map, and the map's root. Sorted by id;
// empty where `centre` is unknown. Where nothing else would be fixed, the oldest free keyframe is.
BundleScope LocalBundleScope(const Map& map, KeyframeId centre, LocalMapId own);

// Does the same where several are at the centre: free are these of the local map `own`, and `own`
// points that they see. Those that the map does not have are skipped.
BundleScope LocalBundleScope(const Map& map, absl::Span<const KeyframeId> centres, LocalMapId own);

// Returns a scope of all keyframes and points. `fixed` are held (those unknown to the map are
// skipped); where none of them is in the map, its root is.
BundleScope GlobalBundleScope(const Map& map, absl::Span<const KeyframeId> fixed);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_BUNDLE_SCOPE_H_
