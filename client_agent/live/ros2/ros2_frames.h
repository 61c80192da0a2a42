// The frames of a robot as /tf_static and /tf say them.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_FRAMES_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_FRAMES_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/live/ros2/ros2_settings.h"
#include "client_agent/ros2/ros2_names.h"
#include "client_agent/ros2/ros2_node.h"
#include "client_agent/source/bag/messages/transforms.h"

namespace corbslam::client_agent {

// Thread-safe. The node must outlive it, or be stopped before its end.
class Ros2Frames {
 public:
  using Listener = std::function<void(int64_t timestamp_ns, const Rigid3d& parent_from_child)>;

  static absl::StatusOr<std::unique_ptr<Ros2Frames>> Make(const Ros2Names& names, Ros2Node& node);

  // Returns the fixed frames so far.
  TransformTree FixedTree() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns x_target = T * x_source of fixed frames. NOT_FOUND says whether /tf would know it,
  // which moves and is not taken.
  absl::StatusOr<Rigid3d> TargetFromSource(const std::string& target,
                                           const std::string& source) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  // From now on `listener` hears, on the node's thread, each message of /tf about this very motion;
  // null: nobody does.
  void SetListener(std::string parent, std::string child, Listener listener)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns the parent that somebody else gives a frame on /tf or /tf_static; empty: nobody does.
  std::string OthersParentOf(const std::string& child) const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Add(const void* sample, bool is_fixed) ABSL_LOCKS_EXCLUDED(mutex_);

  mutable absl::Mutex mutex_;
  TransformTree fixed_ ABSL_GUARDED_BY(mutex_);
  TransformTree all_ ABSL_GUARDED_BY(mutex_);  // The moving ones, too.
  std::map<std::string, std::string> parents_ ABSL_GUARDED_BY(mutex_);
  std::string heard_parent_ ABSL_GUARDED_BY(mutex_);
  std::string heard_child_ ABSL_GUARDED_BY(mutex_);
  Listener listener_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_FRAMES_H_
