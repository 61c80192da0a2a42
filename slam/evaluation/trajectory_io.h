// Trajectory files of the public benchmarks. Errors name the file, the line and the field:
// NOT_FOUND when a file can't be opened, INVALID_ARGUMENT when a line can't be understood.
//
// Columns stand apart by spaces, tabs or commas; a header may have its # or not, and says whether
// the quaternion's w comes first where it names it. What follows a # is a comment. Of each form
// there are two readers: one that leaves rows out which aren't finite and says so, and one that
// refuses them.
#ifndef CORBSLAM_SLAM_EVALUATION_TRAJECTORY_IO_H_
#define CORBSLAM_SLAM_EVALUATION_TRAJECTORY_IO_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/evaluation/pose_rows.h"
#include "slam/evaluation/trajectory.h"

namespace corbslam {

// A row is "time tx ty tz qx qy qz qw", its time in seconds, or in nanoseconds since 1970 without a
// point.
absl::StatusOr<TrajectoryReading> ReadTumFile(const std::string& path);
absl::StatusOr<Trajectory> ReadTumTrajectory(const std::string& path);
// `comment` stands before the rows, behind a #; there is none where it is empty.
absl::Status WriteTumTrajectory(const Trajectory& trajectory, const std::string& path,
                                const std::string& comment = "");
// Returns the row of one pose.
std::string TumRow(const StampedPose& pose);

// A row is twelve numbers: the first three rows of world_from_camera. Times come from `times_path`,
// one number of seconds a line.
absl::StatusOr<TrajectoryReading> ReadKittiFile(const std::string& poses_path,
                                                const std::string& times_path);
absl::StatusOr<TrajectoryReading> ReadKittiFile(const std::string& poses_path,
                                                const std::vector<int64_t>& times_ns);
absl::StatusOr<Trajectory> ReadKittiTrajectory(const std::string& poses_path,
                                               const std::string& times_path);
// Reads the same without times: 10 Hz from zero.
absl::StatusOr<Trajectory> ReadKittiTrajectory(const std::string& poses_path);
absl::Status WriteKittiTrajectory(const Trajectory& trajectory, const std::string& path);

// Reads EuRoC's state_groundtruth_estimate0/data.csv and TUM-VI's mocap0/data.csv: nanoseconds,
// position, quaternion (w first) of the body; what follows is ignored. `body_from_camera` (cam0's
// T_BS) makes the poses the camera's.
absl::StatusOr<TrajectoryReading> ReadEurocFile(const std::string& path,
                                                const Rigid3d& body_from_camera);
absl::StatusOr<Trajectory> ReadEurocTrajectory(const std::string& path,
                                               const Rigid3d& body_from_camera);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EVALUATION_TRAJECTORY_IO_H_
