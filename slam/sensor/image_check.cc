#include "slam/sensor/image_check.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

bool HasSize(const cv::Mat& image, const Camera& camera) {
  return image.dims == 2 && image.cols == camera.width_px && image.rows == camera.height_px;
}

}  // namespace

std::string DescribeImage(const cv::Mat& image) {
  if (image.empty()) return "no image";
  return absl::StrCat(image.cols, "x", image.rows, " ", cv::typeToString(image.type()));
}

absl::Status CheckGreyImage(absl::string_view name, const cv::Mat& image, const Camera& camera) {
  if (image.type() == CV_8UC1 && HasSize(image, camera)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(name, " image: expected ", camera.width_px, "x",
                                                 camera.height_px, " CV_8UC1, given ",
                                                 DescribeImage(image)));
}

absl::Status CheckDepthImage(const cv::Mat& image, const Camera& camera) {
  const bool is_depth = image.type() == CV_16UC1 || image.type() == CV_32FC1;
  if (is_depth && HasSize(image, camera)) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("depth image: expected ", camera.width_px, "x",
                                                 camera.height_px, " CV_16UC1 or CV_32FC1, given ",
                                                 DescribeImage(image)));
}

absl::Status CheckMask(const cv::Mat& mask, const Camera& camera) {
  return mask.empty() ? absl::OkStatus() : CheckGreyImage("mask", mask, camera);
}

bool IsMasked(const cv::Mat& mask, const Eigen::Vector2d& pixel) {
  if (mask.empty()) return false;
  const int x = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, mask.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, mask.rows - 1);
  return mask.at<uint8_t>(y, x) == 0;
}

}  // namespace corbslam
