#include "client_agent/live/ros2/ros2_messages.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "client_agent/ros2/ros2_clock.h"
#include "client_agent/source/bag/files/bag_file.h"

namespace corbslam::client_agent {
namespace {

// Of a quaternion that somebody normalised in floats.
constexpr double kLengthTolerance = 1e-2;

std::string Text(const char* text) { return CleanName(text == nullptr ? "" : text); }

// Names of frames began with a slash once.
std::string FrameId(const char* text) {
  std::string name = Text(text);
  if (!name.empty() && name[0] == '/') name.erase(0, 1);
  return name;
}

absl::string_view Bytes(const dds_sequence_octet& bytes) {
  return {reinterpret_cast<const char*>(bytes._buffer), bytes._length};
}

Eigen::Vector3d Vector(const geometry_msgs_msg_dds__Vector3_& v) { return {v.x, v.y, v.z}; }

}  // namespace

RosHeader FromRos2(const std_msgs_msg_dds__Header_& header) {
  return {Nanoseconds(header.stamp), FrameId(header.frame_id)};
}

RosImage FromRos2(const sensor_msgs_msg_dds__Image_& image) {
  return {FromRos2(image.header),  image.height, image.width,      Text(image.encoding),
          image.is_bigendian != 0, image.step,   Bytes(image.data)};
}

RosCompressedImage FromRos2(const sensor_msgs_msg_dds__CompressedImage_& image) {
  return {FromRos2(image.header), Text(image.format), Bytes(image.data)};
}

RosCameraInfo FromRos2(const sensor_msgs_msg_dds__CameraInfo_& info) {
  RosCameraInfo made;
  made.header = FromRos2(info.header);
  made.height_px = info.height;
  made.width_px = info.width;
  made.distortion_model = Text(info.distortion_model);
  made.d.assign(info.d._buffer, info.d._buffer + info.d._length);
  std::copy(std::begin(info.k), std::end(info.k), made.k.begin());
  std::copy(std::begin(info.r), std::end(info.r), made.r.begin());
  std::copy(std::begin(info.p), std::end(info.p), made.p.begin());
  made.binning_x = info.binning_x;
  made.binning_y = info.binning_y;
  made.roi_x_px = info.roi.x_offset;
  made.roi_y_px = info.roi.y_offset;
  made.roi_height_px = info.roi.height;
  made.roi_width_px = info.roi.width;
  return made;
}

std::optional<ImuSample> FromRos2(const sensor_msgs_msg_dds__Imu_& imu) {
  ImuSample sample;
  sample.timestamp_ns = Nanoseconds(imu.header.stamp);
  sample.angular_velocity_rps = Vector(imu.angular_velocity);
  sample.specific_force_mps2 = Vector(imu.linear_acceleration);
  if (!sample.angular_velocity_rps.allFinite() || !sample.specific_force_mps2.allFinite()) {
    return std::nullopt;
  }
  return sample;
}

std::optional<RosTransform> FromRos2(const geometry_msgs_msg_dds__TransformStamped_& transform) {
  RosTransform made;
  made.parent = FrameId(transform.header.frame_id);
  made.child = FrameId(transform.child_frame_id);
  const geometry_msgs_msg_dds__Quaternion_& q = transform.transform.rotation;
  made.parent_from_child.rotation = Eigen::Quaterniond(q.w, q.x, q.y, q.z);
  made.parent_from_child.translation = Vector(transform.transform.translation);
  const double length = made.parent_from_child.rotation.norm();
  // The condition is written so that NaN is refused.
  if (!(std::abs(length - 1) < kLengthTolerance) ||
      !made.parent_from_child.translation.allFinite() || made.child.empty()) {
    return std::nullopt;
  }
  made.parent_from_child.rotation.normalize();
  return made;
}

}  // namespace corbslam::client_agent
