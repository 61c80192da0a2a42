// Writes a mission as a recording for Foxglove and Rerun: its past, then its robots driving again
// in the map as it is. docs/operations.md says what is on which topic.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MISSION_RECORDING_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MISSION_RECORDING_H_

#include <cstddef>
#include <cstdint>
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

// Something that is said in words once the map has reached a revision.
struct RecordedNote {
  uint64_t revision = 0;
  bool is_warning = false;
  std::string text;
};

// What is known beforehand.
struct RecordedMission {
  std::string mission;
  RobotColours colours;
  std::vector<RecordedOverlap> overlaps;
  std::vector<RecordedNote> notes;
  std::string frame_of_robots =
      "camera";  // What trajectories are of: "camera", "rectified", "body".
};

// One recording. The calls come in this order: AddMoment, End, Finish. Its clock is its own: each
// moment takes a second, from second 1 on, and robots begin to drive a second after the last one.
// Not thread-safe. Errors name the file.
class MissionRecording {
 public:
  // Begins a file that takes the place of one at the path once it is finished.
  static absl::StatusOr<MissionRecording> Create(const std::string& path, RecordedMission mission);

  // Writes the map as it was at the next moment, with all notes up to its revision.
  absl::Status AddMoment(const ToldMap& map);
  // Writes the points of the map as it is in the end, the remaining notes, and the trajectories,
  // whose islands must be the map's. The time is that of the last moment. FAILED_PRECONDITION for
  // an island that is not.
  absl::Status End(const ToldMap& map, const std::vector<RecordedTrajectory>& trajectories);
  absl::Status Finish();

  size_t moments() const { return moments_; }

 private:
  MissionRecording(RecordedMission mission, McapWriter writer)
      : mission_(std::move(mission)), channels_(std::move(writer)) {}

  // Both say where the clock of the recording stands.
  uint64_t LastMomentAt_ns() const;
  uint64_t DriveAt_ns() const;

  absl::Status WriteFrames(const ToldMap& map);
  absl::Status WriteNotes(uint64_t revision);
  absl::Status Note(uint64_t time_ns, bool is_warning, const std::string& text);
  absl::Status WriteMetadata(const ToldMap& map,
                             const std::vector<RecordedTrajectory>& trajectories);

  RecordedMission mission_;
  FoxgloveChannels channels_;
  size_t moments_ = 0;
  size_t notes_written_ = 0;
  std::optional<double> frustum_depth_;  // Once keyframes have shown it; then it stays.
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_MISSION_RECORDING_H_
