// Says what two keyframes both see, and whether they stand where that says.
#ifndef CORBSLAM_MAP_STORE_VIEW_LANDMARK_AGREEMENT_H_
#define CORBSLAM_MAP_STORE_VIEW_LANDMARK_AGREEMENT_H_

#include <cstdint>
#include <vector>

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// A landmark, or a point that is in none, and the keypoints that see it.
struct SharedLandmark {
  MapPointId id;
  uint32_t keypoint_of_a = 0;
  uint32_t keypoint_of_b = 0;
};

// Returns what two keyframes of one island both see; nothing if they are in two islands.
std::vector<SharedLandmark> FindSharedLandmarks(const MissionState& state, KeyframeId a,
                                                KeyframeId b);

// Returns by how many pixels the two keyframes disagree about what they share, in the global layer
// as it is: for each landmark the worse of its two reprojection errors counts, and the median of
// these is returned. `shared` must not be empty.
double LandmarkDisagreementPx(const MissionState& state, KeyframeId a, KeyframeId b,
                              const std::vector<SharedLandmark>& shared);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_LANDMARK_AGREEMENT_H_
