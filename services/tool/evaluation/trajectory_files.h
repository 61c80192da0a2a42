// Trajectories of a mission as files whose times ascend.
#ifndef CORBSLAM_SERVICES_TOOL_EVALUATION_TRAJECTORY_FILES_H_
#define CORBSLAM_SERVICES_TOOL_EVALUATION_TRAJECTORY_FILES_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "services/client/store/served_mission.h"
#include "slam/camera/recorded_camera.h"
#include "slam/evaluation/trajectory.h"

namespace corbslam {

// One local map's poses, in time, no time twice.
struct TrajectoryPart {
  std::string local_map;
  Trajectory poses;
};
// What one file holds: the parts follow each other in time.
using TrajectoryFile = std::vector<TrajectoryPart>;

// Each local map's, by the time of its first pose.
std::vector<TrajectoryPart> PartsOf(const ServedTrajectory& served);

// Parts go into one file as long as each begins after the one before it has ended. One of a robot
// that was started again on the same recording begins another. At least one file, which may be
// empty.
std::vector<TrajectoryFile> ShareFiles(std::vector<TrajectoryPart> parts);
// Each part has a file: of poses in the local maps' own frames.
std::vector<TrajectoryFile> OwnFiles(std::vector<TrajectoryPart> parts);

// The poses of all parts.
Trajectory Join(const TrajectoryFile& file);

// "dir/alpha.txt" for number 1, "dir/alpha+2.txt" for 2: no robot's name has a '+'.
std::string NumberedPath(const std::string& path, size_t number);

// "local map 00ab: poses 1 to 50" for each part.
std::vector<std::string> DescribeParts(const TrajectoryFile& file);

// TUM files at `path`, NumberedPath(path, 2) and so on; comments say what the poses are of, in
// which frame ("in the mission's global frame"), and where a local map begins. UNAVAILABLE names
// the path.
absl::Status WriteTumFiles(const std::vector<TrajectoryFile>& files, PosesOf poses_of,
                           const std::string& frame, const std::string& path);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_TRAJECTORY_FILES_H_
