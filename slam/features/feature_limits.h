// Says how many features of a picture can be asked for.
#ifndef CORBSLAM_SLAM_FEATURES_FEATURE_LIMITS_H_
#define CORBSLAM_SLAM_FEATURES_FEATURE_LIMITS_H_

namespace corbslam {

// With fewer nothing is tracked; a message takes no more (services/convert/limits.h).
inline constexpr int kLeastFeatures = 50;
inline constexpr int kMostFeatures = 20'000;

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FEATURES_FEATURE_LIMITS_H_
