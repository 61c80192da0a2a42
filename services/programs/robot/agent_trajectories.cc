#include "services/programs/robot/agent_trajectories.h"

#include <filesystem>
#include <fstream>
#include <map>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/evaluation/pose_header.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/atomic_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::Agent;
using client_agent::ToString;
using client_agent::TrajectoryPose;

namespace {

absl::StatusOr<std::optional<Rigid3d>> FindWanted(const SensorCalibration& calibration,
                                                  PosesOf poses_of) {
  ASSIGN_OR_RETURN(const RecordedCamera recorded, RecordedCameraOf(calibration));
  return CameraFromWanted(recorded, poses_of);
}

struct LocalMapPath {
  LocalMapId id;
  Trajectory poses;
};

// Returns the paths of the local maps in the order in which they were begun; a path has no poses if
// nothing was tracked.
std::vector<LocalMapPath> SplitByLocalMap(const std::vector<TrajectoryPose>& poses,
                                          const std::optional<Rigid3d>& camera_from_wanted) {
  std::vector<LocalMapPath> paths;
  std::map<LocalMapId, size_t> numbers;
  for (const TrajectoryPose& pose : poses) {
    const auto [it, added] = numbers.try_emplace(pose.local_map, paths.size());
    if (added) paths.push_back({pose.local_map, {}});
    paths[it->second].poses.push_back(
        {pose.timestamp_ns, camera_from_wanted ? pose.local_from_camera * *camera_from_wanted
                                               : pose.local_from_camera});
  }
  if (paths.empty()) paths.emplace_back();
  return paths;
}

// Removes files of further local maps that an earlier drive left: those of two drives side by side
// would be taken for one.
void RemoveLeftOver(const std::string& path, size_t first) {
  std::error_code error;
  for (size_t number = first;; ++number) {
    const std::string left = absl::StrCat(path, ".", number);
    if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(left, error))) return;
    std::string begin(2, ' ');
    std::ifstream(left).read(begin.data(), 2);
    if (begin != "# ") return;
    std::filesystem::remove(left, error);
  }
}

}  // namespace

absl::Status CheckPosesOf(const SensorCalibration& calibration, PosesOf poses_of) {
  return FindWanted(calibration, poses_of).status();
}

absl::Status WriteAgentTrajectories(const Agent& agent, const SensorCalibration& calibration,
                                    PosesOf poses_of, const std::string& path) {
  ASSIGN_OR_RETURN(const auto camera_from_wanted, FindWanted(calibration, poses_of));
  const std::vector<LocalMapPath> paths =
      SplitByLocalMap(agent.LocalTrajectory(), camera_from_wanted);
  if (paths.size() > 1) {
    RETURN_IF_ERROR(CheckForPlainFile(
        path, absl::StrCat("the robot made ", paths.size(), " local maps, each a file")));
  }
  for (size_t i = 0; i < paths.size(); ++i) {
    const std::string comment =
        absl::StrCat(PoseHeaderLine(poses_of), " in the frame of local map ", ToString(paths[i].id),
                     " (", i + 1, " of ", paths.size(), "): timestamp tx ty tz qx qy qz qw");
    RETURN_IF_ERROR(WriteTumTrajectory(paths[i].poses,
                                       i == 0 ? path : absl::StrCat(path, ".", i + 1), comment));
  }
  if (IsForPlainFile(path)) RemoveLeftOver(path, paths.size() + 1);
  return absl::OkStatus();
}

}  // namespace corbslam::services
