#include "client_agent/live/ros2/ros2_frames.h"

#include <ros2_types.h>

#include <optional>

#include "absl/strings/str_cat.h"
#include "client_agent/live/ros2/ros2_messages.h"
#include "client_agent/ros2/ros2_clock.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr Ros2Qos kMoving = {.reliable = true, .transient_local = false, .depth = 100};
constexpr Ros2Qos kFixed = {.reliable = true, .transient_local = true, .depth = 100};
// Frames of a name that changes with every message must not fill memory.
constexpr size_t kMostFrames = 10'000;

}  // namespace

absl::StatusOr<std::unique_ptr<Ros2Frames>> Ros2Frames::Make(const Ros2Names& names,
                                                             Ros2Node& node) {
  auto frames = std::make_unique<Ros2Frames>();
  Ros2Frames* const made = frames.get();
  const dds_topic_descriptor_t& type = tf2_msgs_msg_dds__TFMessage__desc;
  RETURN_IF_ERROR(node.Subscribe(DdsTopic(names.Resolve("/tf_static")), type, kFixed,
                                 [made](const void* sample) { made->Add(sample, true); })
                      .status());
  RETURN_IF_ERROR(node.Subscribe(DdsTopic(names.Resolve("/tf")), type, kMoving,
                                 [made](const void* sample) { made->Add(sample, false); })
                      .status());
  return frames;
}

void Ros2Frames::Add(const void* sample, bool is_fixed) {
  const auto& message = *static_cast<const tf2_msgs_msg_dds__TFMessage_*>(sample);
  const absl::MutexLock lock(&mutex_);
  for (uint32_t i = 0; i < message.transforms._length; ++i) {
    const std::optional<RosTransform> transform = FromRos2(message.transforms._buffer[i]);
    if (!transform.has_value()) continue;
    if (parents_.size() >= kMostFrames && !parents_.contains(transform->child)) continue;
    parents_[transform->child] = transform->parent;
    all_.Add(*transform);
    if (!is_fixed && listener_ != nullptr && transform->child == heard_child_ &&
        transform->parent == heard_parent_) {
      listener_(Nanoseconds(message.transforms._buffer[i].header.stamp),
                transform->parent_from_child);
    }
    if (is_fixed) fixed_.Add(*transform);
  }
}

void Ros2Frames::SetListener(std::string parent, std::string child, Listener listener) {
  const absl::MutexLock lock(&mutex_);
  heard_parent_ = std::move(parent);
  heard_child_ = std::move(child);
  listener_ = std::move(listener);
}

TransformTree Ros2Frames::FixedTree() const {
  const absl::MutexLock lock(&mutex_);
  return fixed_;
}

absl::StatusOr<Rigid3d> Ros2Frames::TargetFromSource(const std::string& target,
                                                     const std::string& source) const {
  const absl::MutexLock lock(&mutex_);
  const std::optional<Rigid3d> found = fixed_.TargetFromSource(target, source);
  if (found.has_value()) return *found;
  const bool moves = all_.TargetFromSource(target, source).has_value();
  return absl::NotFoundError(absl::StrCat(
      "/tf_static has no way from ", target, " to ", source,
      moves ? ": /tf has one, but what moves is not taken: publish it on /tf_static" : ""));
}

std::string Ros2Frames::OthersParentOf(const std::string& child) const {
  const absl::MutexLock lock(&mutex_);
  const auto found = parents_.find(child);
  return found == parents_.end() ? "" : found->second;
}

}  // namespace corbslam::client_agent
