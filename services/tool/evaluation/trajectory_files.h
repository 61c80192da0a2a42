// Writes trajectories of a mission as files whose times ascend.
#ifndef CORBSLAM_SERVICES_TOOL_EVALUATION_TRAJECTORY_FILES_H_
#define CORBSLAM_SERVICES_TOOL_EVALUATION_TRAJECTORY_FILES_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "services/client/store/local_map_names.h"
#include "services/client/store/served_mission.h"
#include "slam/camera/recorded_camera.h"
#include "slam/evaluation/trajectory.h"

namespace corbslam::services {

// The poses of one local map, or of a run that only localised, in one island; sorted by time, no
// time twice.
struct TrajectoryPart {
  std::string local_map;
  Trajectory poses;
  std::string island = {};  // As ServedPose has it.
};
// The content of one file: the parts follow each other in time.
using TrajectoryFile = std::vector<TrajectoryPart>;

// Returns a part for each local map, sorted by the time of its first pose. A run that only
// localised may lie in several islands, each with a frame of its own, and has a part for each.
std::vector<TrajectoryPart> PartsOf(const ServedTrajectory& served);

// Shares the parts among files. A part goes into a file in which all others have ended before it
// begins; where there is none, as for a robot that was started again on the same recording, it
// begins another file. Returns at least one file, which may be empty.
std::vector<TrajectoryFile> ShareFiles(std::vector<TrajectoryPart> parts);
// Gives each part a file of its own, for poses in the local maps' own frames.
std::vector<TrajectoryFile> OwnFiles(std::vector<TrajectoryPart> parts);

// Returns the poses of all parts.
Trajectory Join(const TrajectoryFile& file);

// Returns what a robot's files, or drives, are called beside its name: the first one "", a further
// one "+4" if alpha/4 is the earliest of its local maps. No robot's name has a '+'. Those without
// such names (runs that only localised) are counted, and where a name is taken it is "+4b".
std::vector<std::string> SuffixesOf(const std::vector<TrajectoryFile>& files,
                                    const LocalMapNames& names);

// Returns `path` with each of the suffixes before its ending: "dir/alpha.txt", "dir/alpha+4.txt".
std::vector<std::string> SuffixedPaths(const std::string& path,
                                       const std::vector<std::string>& suffixes);

// Returns "local map alpha/4, 00ab: poses 1 to 50" for each part, without what `names` lacks.
std::vector<std::string> DescribeParts(const TrajectoryFile& file, const LocalMapNames& names = {});

// Writes TUM files at `paths`; comments say what the poses are of, in which frame ("in the
// mission's global frame"), and where a local map begins. UNAVAILABLE names the path.
absl::Status WriteTumFiles(const std::vector<TrajectoryFile>& files, PosesOf poses_of,
                           const std::string& frame, const std::vector<std::string>& paths,
                           const LocalMapNames& names);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_TRAJECTORY_FILES_H_
