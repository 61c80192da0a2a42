// Unpacks depth pictures of ROS's compressed_depth_image_transport.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_COMPRESSED_DEPTH_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_COMPRESSED_DEPTH_H_

#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "client_agent/source/bag/messages/ros_messages.h"

namespace corbslam::client_agent {

// A message's format is "16UC1; compressedDepth" or "32FC1; compressedDepth", perhaps with "png" or
// "rvl" behind. Its data begin with 12 bytes: a number and the two parameters a, b by which depths
// of floats became 16 bits, q = a / depth + b. A PNG follows; or, of RVL (Wilson, Fast Lossless
// Depth Image Compression, ISS 2017), width, height and runs of differences in groups of 4 bits.
//
// Returns CV_16UC1 or CV_32FC1, metres. INVALID_ARGUMENT says what is not whole.
absl::StatusOr<cv::Mat> UnpackCompressedDepth(const RosCompressedImage& image);
absl::StatusOr<cv::Size> CompressedDepthSize(const RosCompressedImage& image);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_COMPRESSED_DEPTH_H_
