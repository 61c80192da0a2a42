// Checks what a sensor is given.
#ifndef CORBSLAM_SLAM_SENSOR_IMAGE_CHECK_H_
#define CORBSLAM_SLAM_SENSOR_IMAGE_CHECK_H_

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "slam/camera/camera.h"

namespace corbslam {

// Describes an image like "640x480 CV_8UC1".
std::string DescribeImage(const cv::Mat& image);

// INVALID_ARGUMENT says what was expected and given, unless the image is CV_8UC1 of the camera's
// size.
absl::Status CheckGreyImage(absl::string_view name, const cv::Mat& image, const Camera& camera);

// INVALID_ARGUMENT in the same way, unless CV_16UC1 or CV_32FC1 of the camera's size.
absl::Status CheckDepthImage(const cv::Mat& image, const Camera& camera);

// INVALID_ARGUMENT in the same way, unless empty or CV_8UC1 of the camera's size.
absl::Status CheckMask(const cv::Mat& mask, const Camera& camera);

// Returns whether the mask (empty: none) covers the pixel, which is inside the picture.
bool IsMasked(const cv::Mat& mask, const Eigen::Vector2d& pixel);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_IMAGE_CHECK_H_
