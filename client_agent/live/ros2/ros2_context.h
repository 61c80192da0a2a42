// What the two sides of corbslam_ros2 share: the node, its settings, the time and the frames.
#ifndef CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_CONTEXT_H_
#define CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_CONTEXT_H_

#include <memory>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/live/ros2/ros2_frames.h"
#include "client_agent/live/ros2/ros2_settings.h"
#include "client_agent/ros2/ros2_arguments.h"
#include "client_agent/ros2/ros2_clock.h"
#include "client_agent/ros2/ros2_graph.h"
#include "client_agent/ros2/ros2_names.h"
#include "client_agent/ros2/ros2_node.h"

namespace corbslam::client_agent {

// What ROS 2's environment says.
struct Ros2Environment {
  std::string domain_id;        // ROS_DOMAIN_ID
  std::string localhost_only;   // ROS_LOCALHOST_ONLY
  std::string discovery_range;  // ROS_AUTOMATIC_DISCOVERY_RANGE
  std::string distro;           // ROS_DISTRO

  static Ros2Environment OfProcess();
};

// Returns the options of a node. INVALID_ARGUMENT names the variable, its value and what it wants.
absl::StatusOr<Ros2NodeOptions> MakeNodeOptions(const Ros2Environment& environment,
                                                const Ros2Names& names);

// How the pictures come, for whoever watches that.
struct Ros2CameraState {
  std::string camera_frame;     // Of the first picture; empty before it.
  bool base_is_of_rig = false;  // /tf_static does not say where the camera sits.
  std::string problem;          // Why nothing is played, or what was left out last.
  const Ros2Subscription* images[2] = {nullptr, nullptr};
};

// Thread-safe, but for Begin.
class Ros2Context {
 public:
  // Starts nothing.
  Ros2Context(const Ros2Names& names, const Ros2Settings& settings, const Ros2NodeOptions& options)
      : names_(names), settings_(settings), options_(options) {}
  ~Ros2Context() { Stop(); }

  // Makes the node, unless it is there. What follows but the settings wants it. Not thread-safe.
  absl::Status Begin();
  // Hears nothing any more.
  void Stop();

  const Ros2Names& names() const { return names_; }
  const Ros2Settings& settings() const { return settings_; }
  Ros2Node& node() { return *node_; }
  const Ros2Clock& clock() const { return *clock_; }
  Ros2Frames& frames() { return *frames_; }
  const Ros2Graph& graph() const { return *graph_; }

  void SetCamera(Ros2CameraState state) ABSL_LOCKS_EXCLUDED(mutex_);
  Ros2CameraState camera() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  const Ros2Names names_;
  const Ros2Settings settings_;
  const Ros2NodeOptions options_;
  std::unique_ptr<Ros2Clock> clock_;
  std::unique_ptr<Ros2Frames> frames_;
  std::unique_ptr<Ros2Node> node_;
  std::unique_ptr<Ros2Graph> graph_;
  mutable absl::Mutex mutex_;
  Ros2CameraState camera_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LIVE_ROS2_ROS2_CONTEXT_H_
