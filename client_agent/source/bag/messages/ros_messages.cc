#include "client_agent/source/bag/messages/ros_messages.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/messages/ros_wire.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr int64_t kNsOfSecond = 1'000'000'000;
// A quaternion that somebody normalised in floats.
constexpr double kUnitTolerance = 1e-2;

absl::Status CheckWhole(const RosWire& wire, absl::string_view type) {
  if (wire.ok()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("a ", type, " ends at ", wire.offset(), " within its field ", wire.missing()));
}

// Names of frames began with a slash once.
std::string FrameName(absl::string_view name) {
  return CleanName(name.substr(name.empty() || name[0] != '/' ? 0 : 1));
}

RosHeader TakeHeader(RosWire& wire) {
  if (wire.is_ros1()) wire.Take<uint32_t>("header.seq");
  RosHeader header;
  const int64_t seconds = wire.is_ros1() ? int64_t{wire.Take<uint32_t>("header.stamp.secs")}
                                         : int64_t{wire.Take<int32_t>("header.stamp.sec")};
  header.stamp_ns = seconds * kNsOfSecond + wire.Take<uint32_t>("header.stamp.nanosec");
  header.frame_id = FrameName(wire.TakeText("header.frame_id"));
  return header;
}

RosTransform TakeTransform(RosWire& wire) {
  RosTransform transform;
  transform.parent = TakeHeader(wire).frame_id;
  transform.child = FrameName(wire.TakeText("transforms.child_frame_id"));
  std::array<double, 7> numbers;
  wire.TakeArray(numbers, "transforms.transform");
  transform.parent_from_child.translation = {numbers[0], numbers[1], numbers[2]};
  transform.parent_from_child.rotation =
      Eigen::Quaterniond(numbers[6], numbers[3], numbers[4], numbers[5]);
  return transform;
}

bool IsMotion(const Rigid3d& motion) {
  return motion.translation.allFinite() &&
         std::abs(motion.rotation.norm() - 1) < kUnitTolerance;  // False for NaN, too.
}

}  // namespace

absl::StatusOr<RosHeader> ReadRosHeader(BagEncoding encoding, absl::string_view bytes) {
  ASSIGN_OR_RETURN(RosWire wire, RosWire::Open(encoding, bytes));
  RosHeader header = TakeHeader(wire);
  RETURN_IF_ERROR(CheckWhole(wire, "std_msgs/Header"));
  return header;
}

absl::StatusOr<RosImage> ReadRosImage(BagEncoding encoding, absl::string_view bytes) {
  ASSIGN_OR_RETURN(RosWire wire, RosWire::Open(encoding, bytes));
  RosImage image;
  image.header = TakeHeader(wire);
  image.height_px = wire.Take<uint32_t>("height");
  image.width_px = wire.Take<uint32_t>("width");
  image.encoding = CleanName(wire.TakeText("encoding"));
  image.is_big_endian = wire.Take<uint8_t>("is_bigendian") != 0;
  image.step = wire.Take<uint32_t>("step");
  image.data = wire.TakeByteList("data");
  RETURN_IF_ERROR(CheckWhole(wire, kImageType));
  return image;
}

absl::StatusOr<RosCompressedImage> ReadRosCompressedImage(BagEncoding encoding,
                                                          absl::string_view bytes) {
  ASSIGN_OR_RETURN(RosWire wire, RosWire::Open(encoding, bytes));
  RosCompressedImage image;
  image.header = TakeHeader(wire);
  image.format = CleanName(wire.TakeText("format"));
  image.data = wire.TakeByteList("data");
  RETURN_IF_ERROR(CheckWhole(wire, kCompressedImageType));
  return image;
}

absl::StatusOr<RosImu> ReadRosImu(BagEncoding encoding, absl::string_view bytes) {
  ASSIGN_OR_RETURN(RosWire wire, RosWire::Open(encoding, bytes));
  RosImu imu;
  imu.header = TakeHeader(wire);
  std::array<double, 13> orientation;  // With its covariance.
  std::array<double, 9> covariance;
  wire.TakeArray(orientation, "orientation");
  wire.TakeArray(imu.angular_velocity_rps, "angular_velocity");
  wire.TakeArray(covariance, "angular_velocity_covariance");
  wire.TakeArray(imu.linear_acceleration_mps2, "linear_acceleration");
  RETURN_IF_ERROR(CheckWhole(wire, kImuType));
  return imu;
}

absl::StatusOr<RosCameraInfo> ReadRosCameraInfo(BagEncoding encoding, absl::string_view bytes) {
  ASSIGN_OR_RETURN(RosWire wire, RosWire::Open(encoding, bytes));
  RosCameraInfo info;
  info.header = TakeHeader(wire);
  info.height_px = wire.Take<uint32_t>("height");
  info.width_px = wire.Take<uint32_t>("width");
  info.distortion_model = CleanName(wire.TakeText("distortion_model"));
  info.d = wire.TakeDoubles("D");
  wire.TakeArray(info.k, "K");
  wire.TakeArray(info.r, "R");
  wire.TakeArray(info.p, "P");
  info.binning_x = wire.Take<uint32_t>("binning_x");
  info.binning_y = wire.Take<uint32_t>("binning_y");
  info.roi_x_px = wire.Take<uint32_t>("roi.x_offset");
  info.roi_y_px = wire.Take<uint32_t>("roi.y_offset");
  info.roi_height_px = wire.Take<uint32_t>("roi.height");
  info.roi_width_px = wire.Take<uint32_t>("roi.width");
  wire.Take<uint8_t>("roi.do_rectify");
  RETURN_IF_ERROR(CheckWhole(wire, kCameraInfoType));
  return info;
}

absl::StatusOr<std::vector<RosTransform>> ReadRosTransforms(BagEncoding encoding,
                                                            absl::string_view bytes) {
  ASSIGN_OR_RETURN(RosWire wire, RosWire::Open(encoding, bytes));
  const auto count = wire.Take<uint32_t>("transforms");
  std::vector<RosTransform> transforms;
  for (uint32_t i = 0; i < count && wire.ok(); ++i) {
    RosTransform transform = TakeTransform(wire);
    if (!wire.ok() || !IsMotion(transform.parent_from_child)) continue;
    transform.parent_from_child.rotation.normalize();
    transforms.push_back(std::move(transform));
  }
  RETURN_IF_ERROR(CheckWhole(wire, kTransformsType));
  return transforms;
}

}  // namespace corbslam::client_agent
