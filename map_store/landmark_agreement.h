// Whether keyframes stand where the landmarks that they see say.
#ifndef CORBSLAM_MAP_STORE_LANDMARK_AGREEMENT_H_
#define CORBSLAM_MAP_STORE_LANDMARK_AGREEMENT_H_

#include <optional>

#include "map_store/mission_state.h"

namespace corbslam::map_store {

// By how many pixels two keyframes of one island disagree about the landmarks that both see, in the
// global layer as it is: of each the worse of its two reprojection errors, and of all the median.
// None where they share none.
std::optional<double> LandmarkDisagreementPx(const MissionState& state, KeyframeId a, KeyframeId b);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_LANDMARK_AGREEMENT_H_
