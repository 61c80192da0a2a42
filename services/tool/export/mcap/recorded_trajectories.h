// Writes where robots were at every frame: their paths, and their cameras while they drive again.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_RECORDED_TRAJECTORIES_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_RECORDED_TRAJECTORIES_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "services/tool/export/mcap/foxglove_channels.h"
#include "slam/evaluation/trajectory.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// A drive of a robot, as far as it lies in one island. A robot that was started again on the same
// times has several drives.
struct RecordedTrajectory {
  std::string robot;
  size_t drive = 1;  // The robot's how manieth.
  LocalMapId island;
  bool in_global_frame = false;
  int64_t drive_begins_ns = 0;  // By the robot's clock.
  Trajectory poses;             // Sorted by time; of the island's frame.
};

// Returns "camera/alpha", "camera/alpha+2", "camera/alpha+2/00c0ffee00c0ffee"; `what` is "camera".
std::string RobotFrame(const RecordedTrajectory& trajectory, const std::string& what);

// Writes all paths at `time_ns`, and from then on each pose as long after it as the drive had
// lasted by the robot's own clock. Returns an error of the file, or INVALID_ARGUMENT for times that
// do not ascend from the drive's begin.
absl::Status WriteTrajectories(const std::vector<RecordedTrajectory>& trajectories,
                               const std::string& what, uint64_t time_ns,
                               FoxgloveChannels& channels);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_RECORDED_TRAJECTORIES_H_
