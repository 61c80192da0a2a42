// What a robot publishes as a node of ROS 2.
#ifndef CORBSLAM_SERVICES_ROS2_ROS2_OUTPUTS_H_
#define CORBSLAM_SERVICES_ROS2_ROS2_OUTPUTS_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/live/ros2/ros2_settings.h"
#include "client_agent/map/near_map.h"
#include "client_agent/ros2/ros2_names.h"
#include "client_agent/ros2/ros2_node.h"
#include "services/ros2/outside_odometry.h"
#include "services/ros2/ros2_poses.h"

namespace corbslam::services {

// A line of /diagnostics.
struct Ros2Diagnosis {
  enum class Level : uint8_t { kOk = 0, kWarning = 1, kError = 2, kStale = 3 };
  Level level = Level::kOk;
  std::string name;  // "tracking", "camera".
  std::string message;
  std::vector<std::pair<std::string, std::string>> values;
};

// Thread-safe. Stamps are those of frames, but for diagnostics.
class Ros2Outputs {
 public:
  // Variances of what nobody knows, m2 and rad2: whoever fuses such a pose gives it no weight.
  static constexpr double kUnknownVariance = 1e6;

  // `settings` and `names` are copied; the node must outlive it.
  static absl::StatusOr<std::unique_ptr<Ros2Outputs>> Make(
      const client_agent::Ros2Names& names, const client_agent::Ros2Settings& settings,
      client_agent::Ros2Node& node);

  // Odometry, poses in the map, and TF of one instant in one message.
  void PublishPoses(const Ros2Poses& poses);
  // map -> odom where somebody else says odom -> base.
  void PublishMapToOdom(const std::vector<StampedMotion>& map_from_odom);
  // base to the camera, once for all that come.
  void PublishBaseToCamera(const std::string& camera_frame, const Rigid3d& base_from_camera);

  bool PathIsWanted() const { return path_->HasReaders(); }
  bool CloudIsWanted() const { return cloud_->HasReaders(); }
  // Poses of the map.
  void PublishPath(const std::vector<StampedMotion>& poses);
  // `map_from_local` holds for the near map's local map.
  void PublishCloud(const client_agent::NearMap& near, const Similarity3d& map_from_local);
  // The first line is the node's status, too.
  void PublishDiagnoses(const std::vector<Ros2Diagnosis>& diagnoses, int64_t now_ns,
                        const std::string& hardware);

 private:
  explicit Ros2Outputs(const client_agent::Ros2Settings& settings) : settings_(settings) {}
  void PublishOdometry(const Ros2Poses& poses);
  void PublishMapPose(const Ros2Poses& poses);
  void PublishTransforms(const Ros2Poses& poses);

  const client_agent::Ros2Settings settings_;
  std::string full_name_;
  client_agent::Ros2Publisher* odometry_ = nullptr;
  client_agent::Ros2Publisher* pose_ = nullptr;
  client_agent::Ros2Publisher* pose_covariance_ = nullptr;
  client_agent::Ros2Publisher* path_ = nullptr;
  client_agent::Ros2Publisher* cloud_ = nullptr;
  client_agent::Ros2Publisher* status_ = nullptr;
  client_agent::Ros2Publisher* diagnostics_ = nullptr;
  client_agent::Ros2Publisher* tf_ = nullptr;
  client_agent::Ros2Publisher* tf_static_ = nullptr;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_ROS2_ROS2_OUTPUTS_H_
