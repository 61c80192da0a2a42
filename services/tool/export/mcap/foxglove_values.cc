#include "services/tool/export/mcap/foxglove_values.h"

namespace corbslam::services {
namespace {

template <typename Message>
void SetPosition(const Eigen::Vector3d& position, Message* message) {
  message->set_x(position.x());
  message->set_y(position.y());
  message->set_z(position.z());
}

}  // namespace

void ToFoxglove(uint64_t time_ns, google::protobuf::Timestamp* message) {
  message->set_seconds(static_cast<int64_t>(time_ns / 1'000'000'000));
  message->set_nanos(static_cast<int32_t>(time_ns % 1'000'000'000));
}

void ToFoxglove(const Eigen::Vector3d& position, foxglove::Vector3* message) {
  SetPosition(position, message);
}

void ToFoxglove(const Eigen::Vector3d& position, foxglove::Point3* message) {
  SetPosition(position, message);
}

void ToFoxglove(const Eigen::Quaterniond& rotation, foxglove::Quaternion* message) {
  SetPosition(rotation.vec(), message);
  message->set_w(rotation.w());
}

void ToFoxglove(const Rigid3d& frame_from_object, foxglove::Pose* message) {
  ToFoxglove(frame_from_object.translation, message->mutable_position());
  ToFoxglove(frame_from_object.rotation, message->mutable_orientation());
}

void ToFoxglove(const Colour& colour, double opacity, foxglove::Color* message) {
  message->set_r(colour.red / 255.0);
  message->set_g(colour.green / 255.0);
  message->set_b(colour.blue / 255.0);
  message->set_a(opacity);
}

void SetTransform(uint64_t time_ns, const std::string& parent, const std::string& child,
                  const Rigid3d& parent_from_child, foxglove::FrameTransform* message) {
  ToFoxglove(time_ns, message->mutable_timestamp());
  message->set_parent_frame_id(parent);
  message->set_child_frame_id(child);
  ToFoxglove(parent_from_child.translation, message->mutable_translation());
  ToFoxglove(parent_from_child.rotation, message->mutable_rotation());
}

}  // namespace corbslam::services
