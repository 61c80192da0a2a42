// Makes a camera's path a function of time.
#ifndef CORBSLAM_SERVICES_SIMULATION_MOTION_POSE_SEQUENCE_H_
#define CORBSLAM_SERVICES_SIMULATION_MOTION_POSE_SEQUENCE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/evaluation/trajectory.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// Immutable. Times count from the first pose, in nanoseconds: the first is 0.
class PoseSequence {
 public:
  // INVALID_ARGUMENT names the pose, for fewer than two poses or times that don't grow.
  static absl::StatusOr<PoseSequence> Make(const Trajectory& trajectory);
  // Makes a sequence of poses `period_ns` apart.
  static absl::StatusOr<PoseSequence> Make(const std::vector<Rigid3d>& world_from_camera,
                                           int64_t period_ns);

  int64_t duration_ns() const { return trajectory_.back().timestamp_ns; }
  const Trajectory& trajectory() const { return trajectory_; }

  // Returns exactly the pose given where there is one, and a smooth path in between (cubic Hermite
  // splines of position and of rotation, whose slopes are the neighbours' finite differences).
  // Before the start and beyond the end it is the first and the last pose.
  Rigid3d PoseAt(int64_t time_ns) const;

 private:
  explicit PoseSequence(Trajectory trajectory) : trajectory_(std::move(trajectory)) {}

  Trajectory trajectory_;
};

// Returns a pose at the same place that looks back.
Rigid3d TurnedBack(const Rigid3d& world_from_camera);

// Reads a file of poses: twelve numbers a line are KITTI's (10 Hz), eight are TUM's. NOT_FOUND and
// INVALID_ARGUMENT name file, line and field.
absl::StatusOr<PoseSequence> ReadPoseSequence(const std::string& path);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_MOTION_POSE_SEQUENCE_H_
