// Reads pictures of recorded sequences as their pixels are stored: not turned by EXIF, and with no
// part that the file does not hold.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_IMAGE_FILE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_IMAGE_FILE_H_

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// Returns what the file holds. NOT_FOUND or INVALID_ARGUMENT, naming the file.
absl::StatusOr<std::string> ReadPictureBytes(const std::string& path);

// Returns CV_8UC1, or CV_16UC1 where the file has 16 bits; colour becomes grey. Returns NOT_FOUND
// or INVALID_ARGUMENT, naming the file: one that is no picture, or one that is cut short.
absl::StatusOr<cv::Mat> ReadGreyImage(const std::string& path);

// Returns the first of the pictures that can be read, among the first ten; the error of the first
// where none can. `paths` holds at least one.
absl::StatusOr<cv::Mat> ReadFirstGrey(const std::vector<std::string>& paths);

// Returns one channel of 16 bits, as it is stored.
absl::StatusOr<cv::Mat> ReadDepthImage(const std::string& path);

// Do the same with the bytes of a file; `name` stands for it in messages.
absl::StatusOr<cv::Mat> DecodeGreyImage(absl::string_view bytes, absl::string_view name);
absl::StatusOr<cv::Mat> DecodeDepthImage(absl::string_view bytes, absl::string_view name);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_PICTURES_IMAGE_FILE_H_
