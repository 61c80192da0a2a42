// Features such as a camera's, for tests: corners on the pixels of their levels, and descriptors
// that the model of descriptors draws.
#ifndef CORBSLAM_SLAM_CODING_TESTING_PLAUSIBLE_FEATURES_H_
#define CORBSLAM_SLAM_CODING_TESTING_PLAUSIBLE_FEATURES_H_

#include <cstddef>
#include <cstdint>

#include "slam/coding/keypoint_model.h"
#include "slam/features/keypoint.h"

namespace corbslam::testing {

// Makes features that are rounded as on the wire, two thirds with a disparity. A seed always gives
// the same.
Features MakePlausibleFeatures(uint32_t seed, size_t count, const PictureSize& picture);

}  // namespace corbslam::testing

#endif  // CORBSLAM_SLAM_CODING_TESTING_PLAUSIBLE_FEATURES_H_
