// Trajectory files of the three public benchmarks. Errors name the file, the line and the field:
// NOT_FOUND when a file can't be opened, INVALID_ARGUMENT when a line can't be understood.
#ifndef CORBSLAM_SLAM_EVALUATION_TRAJECTORY_IO_H_
#define CORBSLAM_SLAM_EVALUATION_TRAJECTORY_IO_H_

#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/evaluation/trajectory.h"

namespace corbslam {

// "time tx ty tz qx qy qz qw" a line, time in seconds; lines that start with # are comments.
// Sorted by time on return.
absl::StatusOr<Trajectory> ReadTumTrajectory(const std::string& path);
absl::Status WriteTumTrajectory(const Trajectory& trajectory, const std::string& path);

// Twelve numbers a line: the first three rows of world_from_camera. Times come from `times_path`,
// one number of seconds a line.
absl::StatusOr<Trajectory> ReadKittiTrajectory(const std::string& poses_path,
                                               const std::string& times_path);
// The same without times: 10 Hz from zero.
absl::StatusOr<Trajectory> ReadKittiTrajectory(const std::string& poses_path);
absl::Status WriteKittiTrajectory(const Trajectory& trajectory, const std::string& path);

// EuRoC's state_groundtruth_estimate0/data.csv: nanoseconds, position, quaternion (w first) of
// the body; `body_from_camera` (cam0's T_BS) makes it the camera's.
absl::StatusOr<Trajectory> ReadEurocTrajectory(const std::string& path,
                                               const Rigid3d& body_from_camera);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EVALUATION_TRAJECTORY_IO_H_
