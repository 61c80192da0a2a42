// Reads trajectories in whatever form a program wrote them.
#ifndef CORBSLAM_SLAM_EVALUATION_TRAJECTORY_FILE_H_
#define CORBSLAM_SLAM_EVALUATION_TRAJECTORY_FILE_H_

#include <string>

#include "absl/status/statusor.h"
#include "slam/evaluation/pose_rows.h"

namespace corbslam {

// Reads what `corbslam mission export` writes, and what the benchmarks give, by what is in the
// file:
//
//   eight columns, time first: TUM's form, seconds, or nanoseconds since 1970
//   nanoseconds and commas: EuRoC's form, at least eight columns
//   twelve columns: KITTI's form. Times are those of `times_path`; if that is empty, of PATH.times
//     or else of times.txt beside it
//   a folder with images.txt, or that file: COLMAP's text model. A time is the picture's name
//   a folder with frame-000000.pose.txt and so on: 7-Scenes, at 30 Hz from 0
//
// Poses stay as the file has them. NOT_FOUND: there is no such file, or there are no times.
// INVALID_ARGUMENT names line and field.
absl::StatusOr<TrajectoryReading> ReadTrajectoryFile(const std::string& path,
                                                     const std::string& times_path = "");

// Reads COLMAP's images.txt, with pictures called ROBOT/NANOSECONDS.png.
absl::StatusOr<TrajectoryReading> ReadColmapImages(const std::string& path);

// Reads 7-Scenes: DIR/frame-000000.pose.txt and so on hold 4 by 4 numbers each, world from camera.
// A time is the number of the frame divided by `rate_hz`. NOT_FOUND: there is no such file in the
// folder.
absl::StatusOr<TrajectoryReading> ReadPoseFiles(const std::string& directory, double rate_hz = 30);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EVALUATION_TRAJECTORY_FILE_H_
