// Pictures from files, with OpenCV's exceptions turned into errors that name the file.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_IMAGE_FILE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_IMAGE_FILE_H_

#include <opencv2/core/mat.hpp>
#include <string>

#include "absl/status/statusor.h"

namespace corbslam {

// CV_8UC1; colour is turned to grey. NOT_FOUND, INVALID_ARGUMENT (no picture).
absl::StatusOr<cv::Mat> ReadGreyImage(const std::string& path);
// CV_16UC1. INVALID_ARGUMENT for anything but one channel of 16 bits.
absl::StatusOr<cv::Mat> ReadDepthImage(const std::string& path);

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_IMAGE_FILE_H_
