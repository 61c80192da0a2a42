// Writes a mission as a recording for Foxglove and Rerun: its past, then its robots driving again
// in the map as it is. docs/exports.md says what is on which topic.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MISSION_RECORDING_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MISSION_RECORDING_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "services/client/store/told_map.h"
#include "services/tool/export/mcap/foxglove_channels.h"
#include "services/tool/export/mcap/recorded_scene.h"
#include "services/tool/export/mcap/recorded_trajectories.h"

namespace corbslam::services {

// A text that is recorded once the map has reached a revision.
struct RecordedNote {
  uint64_t revision = 0;
  bool is_warning = false;
  std::string text;
};

// Of a recording: its own, on which each moment takes a second and all drives begin together behind
// the last one; or the robots', on which poses have their frames' times and a moment that of its
// newest keyframe, so that the recording lies beside what else was recorded of them.
enum class RecordingClock { kOwn, kRobots };

// What is known beforehand.
struct RecordedMission {
  std::string mission;
  RobotColours colours;
  std::vector<RecordedOverlap> overlaps;
  std::vector<RecordedNote> notes;
  std::string frame_of_robots =
      "camera";  // What trajectories are of: "camera", "rectified", "body".
  RecordingClock clock = RecordingClock::kOwn;
  // Of the robots' clock: when keyframes were taken, as far as that is known, and how many moments
  // there will be, about.
  std::map<KeyframeId, int64_t> keyframe_times_ns = {};
  size_t expected_moments = 100;
};

// One recording. The calls come in this order: on the robots' clock BeginDrives; AddMoment, End,
// Finish. On its own clock each moment takes a second, from second 1 on, and robots begin to drive
// a second after the last one. Not thread-safe. Errors name the file.
class MissionRecording {
 public:
  // Begins a file that takes the place of one at the path once it is finished.
  static absl::StatusOr<MissionRecording> Create(const std::string& path, RecordedMission mission);

  // On the robots' clock: takes the trajectories, whose islands must be the map's, to be written
  // between the moments. FAILED_PRECONDITION for an island that is not.
  absl::Status BeginDrives(const ToldMap& map, std::vector<RecordedTrajectory> trajectories);
  // Writes the map as it was at the next moment, with all notes up to its revision. On the robots'
  // clock its points, too, but for moments at which they would be too many for one file.
  absl::Status AddMoment(const ToldMap& map);
  // Writes the points of the map as it is in the end, the remaining notes, and the trajectories (on
  // the robots' clock what is left of those of BeginDrives), whose islands must be the map's. The
  // time is that of the last moment. FAILED_PRECONDITION for an island that is not.
  absl::Status End(const ToldMap& map, std::vector<RecordedTrajectory> trajectories);
  absl::Status Finish();

  size_t moments() const { return moments_; }

 private:
  MissionRecording(RecordedMission mission, McapWriter writer);

  bool IsOnOwnClock() const { return mission_.clock == RecordingClock::kOwn; }
  // Returns when the robots had made the map: when its newest keyframe was taken.
  uint64_t TimeOf(const ToldMap& map) const;
  // Returns whether there is room for the points of one more moment.
  bool TakesPoints(const ToldMap& map);

  absl::Status WriteFrames(const ToldMap& map);
  absl::Status WriteNotes(uint64_t revision);
  absl::Status Note(uint64_t time_ns, bool is_warning, const std::string& text);
  absl::Status WriteMetadata(const ToldMap& map);

  RecordedMission mission_;
  FoxgloveChannels channels_;
  std::optional<TrajectoryPlayer> drives_;
  uint64_t now_ns_;           // Where the clock of the recording stands.
  uint64_t drive_at_ns_ = 0;  // On its own clock: when robots begin to drive again.
  size_t moments_ = 0;
  size_t points_left_ = 0;  // To be written at moments.
  size_t notes_written_ = 0;
  std::optional<double> frustum_depth_;  // Once keyframes have shown it; then it stays.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MISSION_RECORDING_H_
