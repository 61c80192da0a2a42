// A camera's path as a function of time.
#ifndef CORBSLAM_SLAM_SIMULATION_MOTION_POSE_SEQUENCE_H_
#define CORBSLAM_SLAM_SIMULATION_MOTION_POSE_SEQUENCE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/evaluation/trajectory.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// Immutable. Times are from the first pose on, in nanoseconds: the first is 0.
class PoseSequence {
 public:
  // INVALID_ARGUMENT, naming the pose, for fewer than two poses or times that don't grow.
  static absl::StatusOr<PoseSequence> Make(const Trajectory& trajectory);
  // Poses `period_ns` apart.
  static absl::StatusOr<PoseSequence> Make(const std::vector<Rigid3d>& world_from_camera,
                                           int64_t period_ns);

  int64_t duration_ns() const { return trajectory_.back().timestamp_ns; }
  const Trajectory& trajectory() const { return trajectory_; }

  // Smooth in between (cubic Hermite splines of position and of rotation, whose slopes are the
  // neighbours' finite differences); exactly the pose given where there is one. Before the start
  // and beyond the end the first and the last pose.
  Rigid3d PoseAt(int64_t time_ns) const;

 private:
  explicit PoseSequence(Trajectory trajectory) : trajectory_(std::move(trajectory)) {}

  Trajectory trajectory_;
};

// The same place, looking back.
Rigid3d TurnedBack(const Rigid3d& world_from_camera);

// A file of poses: twelve numbers a line are KITTI's (10 Hz, or the times of `times_path` when it
// is not empty), eight are TUM's. NOT_FOUND and INVALID_ARGUMENT, naming file, line and field.
absl::StatusOr<PoseSequence> ReadPoseSequence(const std::string& path,
                                              const std::string& times_path = "");

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SIMULATION_MOTION_POSE_SEQUENCE_H_
