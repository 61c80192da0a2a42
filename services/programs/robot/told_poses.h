// Keeps what a robot says of each frame when it comes, which nothing puts right afterwards: what a
// planner drives by.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_TOLD_POSES_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_TOLD_POSES_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/tracking/tracking_result.h"
#include "services/programs/robot/robot_report.h"
#include "slam/camera/recorded_camera.h"
#include "slam/evaluation/trajectory.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// Poses of the camera as recorded, in the order in which they were told.
struct ToldPaths {
  // In the frame of the robot's local map; empty where it began several.
  Trajectory local;
  // In the mission's global frame, of the frames at which the robot knew where that is.
  Trajectory global;
};

// Breaks of the global path that are no motion of the camera: a correction of the local map, or of
// its place in the global frame.
struct ToldJumps {
  uint64_t count = 0;
  double largest_m = 0;
  double sum_m = 0;

  bool operator==(const ToldJumps&) const = default;
};

// Not thread-safe.
class ToldPoses {
 public:
  // Jumps are counted in any case; paths grow with every frame.
  explicit ToldPoses(const RecordedCamera& recorded, bool keeps_paths = true)
      : camera_from_recorded_(recorded.camera_from_recorded), keeps_paths_(keeps_paths) {}

  void Add(const client_agent::TrackingResult& result);

  const ToldPaths& paths() const { return paths_; }
  const ToldJumps& jumps() const { return jumps_; }

 private:
  // The last frame's, where it had a pose in the global frame.
  struct Last {
    uint64_t epoch = 0;
    Similarity3d global_from_local;
    Rigid3d global_from_camera;
    Rigid3d odom_from_camera;
  };

  void AddGlobal(const client_agent::TrackingResult& result, const Similarity3d& global_from_local);

  const Rigid3d camera_from_recorded_;
  const bool keeps_paths_;
  ToldPaths paths_;
  ToldJumps jumps_;
  std::optional<Last> last_;
  std::optional<LocalMapId> local_map_;
  bool has_several_ = false;
};

void AddJumps(const ToldJumps& jumps, RobotReport& report);

// Writes STEM.local.tum and STEM.global.tum, in TUM's form; a path that nobody was told has no
// rows. UNAVAILABLE names the file.
absl::Status WriteToldPaths(const ToldPaths& paths, const std::string& stem);
// Reads them. NOT_FOUND or INVALID_ARGUMENT as ReadTumTrajectory.
absl::StatusOr<ToldPaths> ReadToldPaths(const std::string& stem);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_TOLD_POSES_H_
