// Shows what becomes of two maps once a fusing is committed, for tests.
#ifndef CORBSLAM_SLAM_FUSING_TESTING_FUSED_MAPS_H_
#define CORBSLAM_SLAM_FUSING_TESTING_FUSED_MAPS_H_

#include <map>

#include "slam/exchange/fusion_worker.h"
#include "slam/verification/testing/synthetic_world.h"

namespace corbslam::testing {

// Returns both maps in the target's frame, with the result's poses, positions, merges and
// rejections.
Map ApplyFusing(const Map& target, const Map& source, const FuseMapsResult& result);

std::map<KeyframeId, Rigid3d> JoinTruth(const SyntheticMap& a, const SyntheticMap& b);

// Returns a copy in which keyframes from `from` on see points of their own instead of those that
// earlier keyframes see, as if the loop had not been noticed.
Map SplitPoints(const Map& map, uint32_t from);

}  // namespace corbslam::testing

#endif  // CORBSLAM_SLAM_FUSING_TESTING_FUSED_MAPS_H_
