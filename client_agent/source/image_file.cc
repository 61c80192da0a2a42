#include "client_agent/source/image_file.h"

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

absl::StatusOr<cv::Mat> ReadImage(const std::string& path, int flags) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return absl::NotFoundError(absl::StrCat("no picture ", path));
  }
  try {
    cv::Mat image = cv::imread(path, flags);
    if (!image.empty()) return image;
  } catch (const cv::Exception& exception) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", exception.what()));
  }
  return absl::InvalidArgumentError(absl::StrCat(path, ": no picture that can be read"));
}

}  // namespace

absl::StatusOr<cv::Mat> ReadGreyImage(const std::string& path) {
  return ReadImage(path, cv::IMREAD_GRAYSCALE);
}

absl::StatusOr<cv::Mat> ReadDepthImage(const std::string& path) {
  ASSIGN_OR_RETURN(cv::Mat image, ReadImage(path, cv::IMREAD_UNCHANGED));
  if (image.type() != CV_16UC1) {
    return absl::InvalidArgumentError(absl::StrCat(
        path, ": a depth image has one channel of 16 bits, this one is of OpenCV type ",
        image.type()));
  }
  return image;
}

}  // namespace corbslam
