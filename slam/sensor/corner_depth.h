// Finds the depth of a keypoint in a depth image.
#ifndef CORBSLAM_SLAM_SENSOR_CORNER_DEPTH_H_
#define CORBSLAM_SLAM_SENSOR_CORNER_DEPTH_H_

#include <opencv2/core/mat.hpp>

#include "slam/features/keypoint.h"

namespace corbslam {

// A corner's pixel lies at most so far from its edge, in pixels of its octave.
inline constexpr double kCornerReach_px = 1.5;
// A surface's depths in so small a window, sorted, differ by no larger factor from one to the next.
inline constexpr double kDepthStep = 1.05;

// Returns the depth in metres; 0 where the sensor saw none. It is that of the keypoint's own pixel,
// unless there is a step within its reach: a corner at the edge of something moves with it,
// wherever beside the edge its pixel happens to lie, so that it gets the depth of the nearer side.
// `depth` is CV_16UC1 in units of which there are `units_per_m` (65535: none), or CV_32FC1 in
// metres; `raw` is in its pixels, as seen (distorted).
double CornerDepth(const cv::Mat& depth, const Keypoint& raw, double units_per_m);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_CORNER_DEPTH_H_
