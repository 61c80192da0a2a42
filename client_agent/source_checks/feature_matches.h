// Finds matches between two pictures without knowledge of their geometry.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_FEATURE_MATCHES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_FEATURE_MATCHES_H_

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "slam/features/keypoint.h"

namespace corbslam::client_agent {

// The features are few and spread evenly: statistics need hundreds of matches, not thousands.
// Pictures wider than 500 pixels are halved first; positions and octaves' scales are in pixels of
// `grey` all the same.
struct CheckFeatures {
  Features features;
  double scale = 1;  // Pixels of `grey` per pixel of the picture that features were found in.
};
CheckFeatures ExtractCheckFeatures(const cv::Mat& grey);

struct FeatureMatch {
  Eigen::Vector2d in_a;
  Eigen::Vector2d in_b;
  double scale = 1;  // Pixels per pixel of the octave in a.
};

// Pairs of features each of which is the other's most similar one, clearly so against the second.
std::vector<FeatureMatch> MatchFeatures(const CheckFeatures& a, const CheckFeatures& b);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_FEATURE_MATCHES_H_
