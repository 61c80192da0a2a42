// Finds map points that a keyframe sees as well, or sees already as another point.
#ifndef CORBSLAM_SLAM_MATCHING_FUSE_MATCHING_H_
#define CORBSLAM_SLAM_MATCHING_FUSE_MATCHING_H_

#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "slam/map/map.h"

namespace corbslam {

struct FuseProposal {
  MapPointId point;
  uint32_t keypoint = 0;
  // Point that the keypoint observes already (a duplicate of `point`), or invalid.
  MapPointId existing;
};

// Projects the points into the keyframe and proposes each that lands within `widening` radii (and
// the 95 % bound of the reprojection error) of a keypoint that looks like it. Points that the
// keyframe sees already and ids unknown to the map are skipped. Proposals are sorted by keypoint,
// then point; several points may claim one keypoint. Pure.
std::vector<FuseProposal> FindFusable(const Map& map, const Keyframe& keyframe,
                                      absl::Span<const MapPointId> points, double widening = 3.0);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MATCHING_FUSE_MATCHING_H_
