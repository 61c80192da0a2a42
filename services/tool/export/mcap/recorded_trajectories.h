// Writes where robots were at every frame: their paths, and their cameras while they drive again.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_RECORDED_TRAJECTORIES_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_RECORDED_TRAJECTORIES_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "services/tool/export/mcap/foxglove_channels.h"
#include "services/tool/export/mcap/recorded_scene.h"
#include "slam/evaluation/trajectory.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// A drive of a robot, as far as it lies in one island. A robot that was started again on the same
// times has several drives.
struct RecordedTrajectory {
  std::string robot;
  std::string suffix;  // "", or what tells the robot's further drives apart, as "+4".
  LocalMapId island;
  bool in_global_frame = false;
  int64_t drive_begins_ns = 0;  // By the robot's clock.
  Trajectory poses;             // Sorted by time; of the island's frame.
  // Where nothing connects a pose with the one before, ascending, 0 included: tracking was lost, or
  // another local map began.
  std::vector<size_t> pieces;
};

// Returns "camera/alpha", "camera/alpha+4", "camera/alpha+4/00c0ffee00c0ffee"; `what` is "camera".
std::string RobotFrame(const RecordedTrajectory& trajectory, const std::string& what);

// Writes trajectories in the order of a recording's time. Not thread-safe.
class TrajectoryPlayer {
 public:
  // Gives each pose its time: as long after `begin_ns` as the drive had lasted by the robot's own
  // clock or, without one, what that clock said. INVALID_ARGUMENT for times that do not ascend from
  // the drive's begin or, by the robot's own clock, lie before 0.
  static absl::StatusOr<TrajectoryPlayer> Create(std::vector<RecordedTrajectory> trajectories,
                                                 std::string what, RobotColours colours,
                                                 std::optional<uint64_t> begin_ns);

  // Writes all poses up to that time; before the first of a trajectory, and at its time, its path,
  // as poses and as a line with gaps. With `begin_ns` all paths have that time.
  absl::Status PlayUntil(uint64_t time_ns, FoxgloveChannels& channels);

  // Returns the times of the first and the last pose; nullopt if there is none.
  std::optional<uint64_t> first_ns() const;
  std::optional<uint64_t> last_ns() const;
  const std::vector<RecordedTrajectory>& trajectories() const { return trajectories_; }

 private:
  struct Moment {
    uint64_t time_ns = 0;
    size_t trajectory = 0;
    size_t pose = 0;
  };

  TrajectoryPlayer(std::vector<RecordedTrajectory> trajectories, std::string what,
                   RobotColours colours)
      : trajectories_(std::move(trajectories)),
        what_(std::move(what)),
        colours_(std::move(colours)) {}
  absl::Status Collect(std::optional<uint64_t> begin_ns);
  absl::Status Play(const Moment& moment, FoxgloveChannels& channels) const;
  absl::Status WritePath(const RecordedTrajectory& trajectory, uint64_t time_ns,
                         FoxgloveChannels& channels) const;

  std::vector<RecordedTrajectory> trajectories_;
  std::string what_;
  RobotColours colours_;
  std::vector<Moment> moments_;  // Sorted.
  size_t played_ = 0;
  std::optional<uint64_t> begin_ns_;
  bool has_begun_ = false;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_RECORDED_TRAJECTORIES_H_
