#include "services/ros2/ros2_outputs.h"

#include <ros2_types.h>

#include <algorithm>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "client_agent/ros2/ros2_clock.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::DdsTopic;
using client_agent::NearMap;
using client_agent::Ros2Names;
using client_agent::Ros2Node;
using client_agent::Ros2Qos;
using client_agent::Ros2Settings;
using client_agent::Ros2Time;

namespace {

using Transform = geometry_msgs_msg_dds__TransformStamped_;

constexpr Ros2Qos kTransforms = {.reliable = true, .transient_local = false, .depth = 100};
constexpr uint8_t kFloat32 = 7;  // PointField's.

// DDS only reads what it is to send.
char* Text(const std::string& text) { return const_cast<char*>(text.c_str()); }

std_msgs_msg_dds__Header_ Header(int64_t timestamp_ns, const std::string& frame) {
  return {Ros2Time(timestamp_ns), Text(frame)};
}

template <typename Sequence, typename Element>
Sequence Sent(std::vector<Element>& elements) {
  Sequence sequence = {};
  sequence._length = sequence._maximum = static_cast<uint32_t>(elements.size());
  sequence._buffer = elements.data();
  return sequence;
}

geometry_msgs_msg_dds__Quaternion_ Rotation(const Eigen::Quaterniond& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}

geometry_msgs_msg_dds__Pose_ Pose(const Rigid3d& pose) {
  const Eigen::Vector3d& t = pose.translation;
  return {{t.x(), t.y(), t.z()}, Rotation(pose.rotation)};
}

Transform MakeTransform(int64_t timestamp_ns, const std::string& parent, const std::string& child,
                        const Rigid3d& parent_from_child) {
  const Eigen::Vector3d& t = parent_from_child.translation;
  return {Header(timestamp_ns, parent),
          Text(child),
          {{t.x(), t.y(), t.z()}, Rotation(parent_from_child.rotation)}};
}

void Publish(client_agent::Ros2Publisher& topic, std::vector<Transform>& transforms) {
  if (transforms.empty()) return;
  const tf2_msgs_msg_dds__TFMessage_ message = {
      Sent<decltype(tf2_msgs_msg_dds__TFMessage_::transforms)>(transforms)};
  topic.Publish(&message);
}

// ROS has covariances row by row, in the order x, y, z, rotations about them, as we have.
void WriteCovariance(const std::optional<Matrix6d>& covariance, double (&written)[36]) {
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) {
      const double unknown = row == column ? Ros2Outputs::kUnknownVariance : 0;
      written[6 * row + column] = covariance.has_value() ? (*covariance)(row, column) : unknown;
    }
  }
}

void AppendPoint(const Eigen::Vector3f& point, float shared, std::vector<uint8_t>& bytes) {
  const float fields[4] = {point.x(), point.y(), point.z(), shared};
  const size_t at = bytes.size();
  bytes.resize(at + sizeof(fields));
  std::memcpy(&bytes[at], fields, sizeof(fields));
}

}  // namespace

absl::StatusOr<std::unique_ptr<Ros2Outputs>> Ros2Outputs::Make(const Ros2Names& names,
                                                               const Ros2Settings& settings,
                                                               Ros2Node& node) {
  std::unique_ptr<Ros2Outputs> outputs(new Ros2Outputs(settings));
  outputs->full_name_ = names.full_name();
  struct Wanted {
    client_agent::Ros2Publisher** publisher;
    const char* name;
    const dds_topic_descriptor_t& type;
    Ros2Qos qos;
  };
  const Wanted all[] = {
      {&outputs->odometry_, "visual_slam/tracking/odometry", nav_msgs_msg_dds__Odometry__desc,
       settings.odometry_qos},
      {&outputs->pose_, "visual_slam/tracking/vo_pose", geometry_msgs_msg_dds__PoseStamped__desc,
       client_agent::kDefaultQos},
      {&outputs->pose_covariance_, "visual_slam/tracking/vo_pose_covariance",
       geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc, client_agent::kDefaultQos},
      {&outputs->path_, "visual_slam/tracking/slam_path", nav_msgs_msg_dds__Path__desc,
       client_agent::kDefaultQos},
      {&outputs->cloud_, "visual_slam/vis/landmarks_cloud", sensor_msgs_msg_dds__PointCloud2__desc,
       client_agent::kDefaultQos},
      {&outputs->status_, "visual_slam/status", diagnostic_msgs_msg_dds__DiagnosticStatus__desc,
       client_agent::kDefaultQos},
      {&outputs->diagnostics_, "/diagnostics", diagnostic_msgs_msg_dds__DiagnosticArray__desc,
       client_agent::kDefaultQos},
      {&outputs->tf_, "/tf", tf2_msgs_msg_dds__TFMessage__desc, kTransforms},
      {&outputs->tf_static_, "/tf_static", tf2_msgs_msg_dds__TFMessage__desc,
       client_agent::kLatched}};
  for (const Wanted& wanted : all) {
    ASSIGN_OR_RETURN(*wanted.publisher,
                     node.Advertise(DdsTopic(names.Resolve(wanted.name)), wanted.type, wanted.qos));
  }
  return outputs;
}

void Ros2Outputs::PublishPoses(const Ros2Poses& poses) {
  // Who hears the odometry may look up the same instant at once.
  PublishTransforms(poses);
  PublishOdometry(poses);
  PublishMapPose(poses);
}

void Ros2Outputs::PublishOdometry(const Ros2Poses& poses) {
  if (!poses.odom_from_base.has_value()) return;
  nav_msgs_msg_dds__Odometry_ message = {};
  message.header = Header(poses.timestamp_ns, settings_.odom_frame);
  message.child_frame_id = Text(settings_.base_frame);
  message.pose.pose = Pose(*poses.odom_from_base);
  WriteCovariance(poses.odom_covariance, message.pose.covariance);
  const Vector6d velocity = poses.velocity.value_or(Vector6d::Zero());
  message.twist.twist.linear = {velocity[0], velocity[1], velocity[2]};
  message.twist.twist.angular = {velocity[3], velocity[4], velocity[5]};
  // How sure the velocity is nobody estimates.
  WriteCovariance(std::nullopt, message.twist.covariance);
  odometry_->Publish(&message);
}

void Ros2Outputs::PublishMapPose(const Ros2Poses& poses) {
  if (!poses.map_from_base.has_value()) return;
  geometry_msgs_msg_dds__PoseStamped_ pose = {Header(poses.timestamp_ns, settings_.map_frame),
                                              Pose(*poses.map_from_base)};
  pose_->Publish(&pose);
  // Without a covariance there is none: who fuses poses passes over this one.
  if (!poses.map_covariance.has_value()) return;
  geometry_msgs_msg_dds__PoseWithCovarianceStamped_ sure = {};
  sure.header = pose.header;
  sure.pose.pose = pose.pose;
  WriteCovariance(poses.map_covariance, sure.pose.covariance);
  pose_covariance_->Publish(&sure);
}

void Ros2Outputs::PublishTransforms(const Ros2Poses& poses) {
  std::vector<Transform> transforms;
  if (!settings_.publish_odom_to_base_tf) return;  // map -> odom follows with the other's odom.
  if (poses.odom_from_base.has_value()) {
    transforms.push_back(MakeTransform(poses.timestamp_ns, settings_.odom_frame,
                                       settings_.base_frame, *poses.odom_from_base));
  }
  const std::optional<Rigid3d> map_from_odom = poses.MapFromOdom();
  if (settings_.publish_map_to_odom_tf && map_from_odom.has_value()) {
    transforms.push_back(MakeTransform(poses.timestamp_ns, settings_.map_frame,
                                       settings_.odom_frame, *map_from_odom));
  }
  Publish(*tf_, transforms);
}

void Ros2Outputs::PublishMapToOdom(const std::vector<StampedMotion>& map_from_odom) {
  std::vector<Transform> transforms;
  for (const StampedMotion& stamped : map_from_odom) {
    transforms.push_back(MakeTransform(stamped.timestamp_ns, settings_.map_frame,
                                       settings_.odom_frame, stamped.motion));
  }
  Publish(*tf_, transforms);
}

void Ros2Outputs::PublishBaseToCamera(const std::string& camera_frame,
                                      const Rigid3d& base_from_camera) {
  std::vector<Transform> transforms = {
      MakeTransform(0, settings_.base_frame, camera_frame, base_from_camera)};
  Publish(*tf_static_, transforms);
}

void Ros2Outputs::PublishPath(const std::vector<StampedMotion>& poses) {
  if (poses.empty()) return;
  std::vector<geometry_msgs_msg_dds__PoseStamped_> stamped;
  for (const StampedMotion& pose : poses) {
    stamped.push_back({Header(pose.timestamp_ns, settings_.map_frame), Pose(pose.motion)});
  }
  const nav_msgs_msg_dds__Path_ message = {Header(poses.back().timestamp_ns, settings_.map_frame),
                                           Sent<decltype(nav_msgs_msg_dds__Path_::poses)>(stamped)};
  path_->Publish(&message);
}

void Ros2Outputs::PublishCloud(const NearMap& near, const Similarity3d& map_from_local) {
  std::vector<uint8_t> bytes;
  const auto append = [&](const std::vector<Eigen::Vector3f>& points, float shared) {
    for (const Eigen::Vector3f& point : points) {
      AppendPoint((map_from_local * point.cast<double>()).cast<float>(), shared, bytes);
    }
  };
  append(near.own_points, 0);
  append(near.shared_points, 1);
  const std::string names[4] = {"x", "y", "z", "intensity"};
  std::vector<sensor_msgs_msg_dds__PointField_> fields;
  for (uint32_t i = 0; i < 4; ++i) {
    fields.push_back({Text(names[i]), static_cast<uint32_t>(4 * i), kFloat32, 1});
  }
  sensor_msgs_msg_dds__PointCloud2_ message = {};
  message.header = Header(near.timestamp_ns, settings_.map_frame);
  message.height = 1;
  message.width = static_cast<uint32_t>(bytes.size() / 16);
  message.fields = Sent<decltype(message.fields)>(fields);
  message.point_step = 16;
  message.row_step = static_cast<uint32_t>(bytes.size());
  message.data = Sent<decltype(message.data)>(bytes);
  message.is_dense = true;
  cloud_->Publish(&message);
}

void Ros2Outputs::PublishDiagnoses(const std::vector<Ros2Diagnosis>& diagnoses, int64_t now_ns,
                                   const std::string& hardware) {
  if (diagnoses.empty()) return;
  std::vector<std::string> names;
  std::vector<std::vector<diagnostic_msgs_msg_dds__KeyValue_>> values;
  std::vector<diagnostic_msgs_msg_dds__DiagnosticStatus_> lines;
  for (const Ros2Diagnosis& diagnosis : diagnoses) {
    names.push_back(absl::StrCat(full_name_.substr(1), ": ", diagnosis.name));
    auto& of_line = values.emplace_back();
    for (const auto& [key, value] : diagnosis.values) of_line.push_back({Text(key), Text(value)});
  }
  // Only now do the texts stay where they are.
  for (size_t i = 0; i < diagnoses.size(); ++i) {
    diagnostic_msgs_msg_dds__DiagnosticStatus_ line = {};
    line.level = static_cast<uint8_t>(diagnoses[i].level);
    line.name = Text(names[i]);
    line.message = Text(diagnoses[i].message);
    line.hardware_id = Text(hardware);
    line.values = Sent<decltype(line.values)>(values[i]);
    lines.push_back(line);
  }
  const std::string no_frame;
  const diagnostic_msgs_msg_dds__DiagnosticArray_ message = {
      Header(now_ns, no_frame),
      Sent<decltype(diagnostic_msgs_msg_dds__DiagnosticArray_::status)>(lines)};
  diagnostics_->Publish(&message);
  status_->Publish(&lines[0]);
}

}  // namespace corbslam::services
