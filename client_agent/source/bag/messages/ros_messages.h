// The messages of ROS that a camera's pictures need, whichever ROS wrote them.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_ROS_MESSAGES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_ROS_MESSAGES_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/bag/files/bag_file.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::client_agent {

inline constexpr absl::string_view kImageType = "sensor_msgs/Image";
inline constexpr absl::string_view kCompressedImageType = "sensor_msgs/CompressedImage";
inline constexpr absl::string_view kCameraInfoType = "sensor_msgs/CameraInfo";
inline constexpr absl::string_view kImuType = "sensor_msgs/Imu";
inline constexpr absl::string_view kTransformsType = "tf2_msgs/TFMessage";
inline constexpr absl::string_view kOldTransformsType = "tf/tfMessage";

struct RosHeader {
  int64_t stamp_ns = 0;
  std::string frame_id;
};

struct RosImage {
  RosHeader header;
  uint32_t height_px = 0;
  uint32_t width_px = 0;
  std::string encoding;
  bool is_big_endian = false;
  uint32_t step = 0;       // Bytes a row.
  absl::string_view data;  // The message's own bytes.
};

struct RosCompressedImage {
  RosHeader header;
  std::string format;
  absl::string_view data;  // The message's own bytes.
};

struct RosCameraInfo {
  RosHeader header;
  uint32_t height_px = 0;
  uint32_t width_px = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k = {};
  std::array<double, 9> r = {};
  std::array<double, 12> p = {};
  uint32_t binning_x = 0;
  uint32_t binning_y = 0;
  uint32_t roi_x_px = 0;
  uint32_t roi_y_px = 0;
  uint32_t roi_height_px = 0;
  uint32_t roi_width_px = 0;
};

// Without what an IMU makes of its measurements (orientation), and without covariances.
struct RosImu {
  RosHeader header;
  Eigen::Vector3d angular_velocity_rps = Eigen::Vector3d::Zero();
  // Of REP 145: what holds it up counts, as in ImuSample.
  Eigen::Vector3d linear_acceleration_mps2 = Eigen::Vector3d::Zero();
};

struct RosTransform {
  std::string parent;
  std::string child;
  Rigid3d parent_from_child;
};

// Each reads a message; INVALID_ARGUMENT names the field that is not whole, with its offset in the
// message. What is longer than the message's type is read without its end.
absl::StatusOr<RosHeader> ReadRosHeader(BagEncoding encoding, absl::string_view bytes);
absl::StatusOr<RosImage> ReadRosImage(BagEncoding encoding, absl::string_view bytes);
absl::StatusOr<RosCompressedImage> ReadRosCompressedImage(BagEncoding encoding,
                                                          absl::string_view bytes);
absl::StatusOr<RosCameraInfo> ReadRosCameraInfo(BagEncoding encoding, absl::string_view bytes);
absl::StatusOr<RosImu> ReadRosImu(BagEncoding encoding, absl::string_view bytes);
// Leaves out transforms that are no rigid motions.
absl::StatusOr<std::vector<RosTransform>> ReadRosTransforms(BagEncoding encoding,
                                                            absl::string_view bytes);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_MESSAGES_ROS_MESSAGES_H_
