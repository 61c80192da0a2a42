// Makes pictures of ROS's Image and CompressedImage.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_ROS_PICTURES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_ROS_PICTURES_H_

#include <opencv2/core/mat.hpp>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/bag/messages/ros_messages.h"

namespace corbslam::client_agent {

// Of what a message holds, before it is decoded.
struct RosPictureForm {
  std::string encoding;  // "rgb8", "16UC1; compressedDepth png", "jpeg".
  cv::Size size;         // 0x0: not known before it is decoded.
  bool can_be_grey = false;
  bool can_be_depth = false;
};
RosPictureForm FormOf(const RosImage& image);
RosPictureForm FormOf(const RosCompressedImage& image);

// Returns CV_8UC1, or CV_16UC1 of 16 bits a pixel. INVALID_ARGUMENT names the field, and what is
// read; a message is never taken by its word about a size.
absl::StatusOr<cv::Mat> GreyOf(const RosImage& image);
absl::StatusOr<cv::Mat> GreyOf(const RosCompressedImage& image);
// Returns CV_16UC1, in the recording's units (REP 118: millimetres), or CV_32FC1 in metres.
absl::StatusOr<cv::Mat> DepthOf(const RosImage& image);
absl::StatusOr<cv::Mat> DepthOf(const RosCompressedImage& image);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_ROS_PICTURES_H_
