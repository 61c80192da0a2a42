#include "services/tool/export/mcap/mission_recording.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "foxglove/log.pb.h"
#include "services/tool/export/mcap/foxglove_values.h"
#include "services/tool/export/mcap/frame_names.h"
#include "services/tool/export/mcap/island_layout.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr char kName[] = "corbslam";
constexpr char kFramesTopic[] = "/frames";
constexpr char kLogTopic[] = "/log";
constexpr uint64_t kSecond_ns = 1'000'000'000;
// Of frusta while no two keyframes have shown how far apart they usually are.
constexpr double kFirstFrustumDepth = 0.1;

// Turns a camera's axes (x right, y down, z forward) so that z points up.
Rigid3d UprightFromMission() {
  const double half = std::sqrt(0.5);
  return {Eigen::Quaterniond(half, -half, 0, 0), Eigen::Vector3d::Zero()};
}

}  // namespace

absl::StatusOr<MissionRecording> MissionRecording::Create(const std::string& path,
                                                          RecordedMission mission) {
  std::stable_sort(
      mission.notes.begin(), mission.notes.end(),
      [](const RecordedNote& a, const RecordedNote& b) { return a.revision < b.revision; });
  ASSIGN_OR_RETURN(McapWriter writer, McapWriter::Create(path, kName));
  return MissionRecording(std::move(mission), std::move(writer));
}

// Some programs take time 0 for no time, so that the clock begins at second 1.
uint64_t MissionRecording::LastMomentAt_ns() const {
  return std::max<uint64_t>(1, moments_) * kSecond_ns;
}

uint64_t MissionRecording::DriveAt_ns() const { return LastMomentAt_ns() + kSecond_ns; }

absl::Status MissionRecording::AddMoment(const ToldMap& map) {
  ++moments_;
  const uint64_t time_ns = LastMomentAt_ns();
  if (!frustum_depth_.has_value()) frustum_depth_ = ChooseFrustumDepth(map);
  RETURN_IF_ERROR(WriteFrames(map));
  RETURN_IF_ERROR(WriteKeyframes(map, mission_.colours, frustum_depth_.value_or(kFirstFrustumDepth),
                                 time_ns, channels_));
  RETURN_IF_ERROR(WriteOverlaps(map, mission_.overlaps, time_ns, channels_));
  RETURN_IF_ERROR(Note(
      time_ns, /*is_warning=*/false,
      absl::StrCat("the map at revision ", map.revision, ": ", map.CountKeyframes(), " keyframes, ",
                   map.islands.size(), map.islands.size() == 1 ? " island" : " islands")));
  return WriteNotes(map.revision);
}

absl::Status MissionRecording::WriteFrames(const ToldMap& map) {
  const uint64_t time_ns = LastMomentAt_ns();
  foxglove::FrameTransforms frames;
  SetTransform(time_ns, kUprightFrame, kMissionFrame, UprightFromMission(),
               frames.add_transforms());
  for (const auto& [id, place] : PlaceIslands(map.islands)) {
    SetTransform(time_ns, kMissionFrame, IslandFrame(id), {Eigen::Quaterniond::Identity(), place},
                 frames.add_transforms());
  }
  return channels_.Write(kFramesTopic, time_ns, frames);
}

absl::Status MissionRecording::WriteNotes(uint64_t revision) {
  for (; notes_written_ < mission_.notes.size(); ++notes_written_) {
    const RecordedNote& note = mission_.notes[notes_written_];
    if (note.revision > revision) break;
    RETURN_IF_ERROR(Note(LastMomentAt_ns(), note.is_warning, note.text));
  }
  return absl::OkStatus();
}

absl::Status MissionRecording::Note(uint64_t time_ns, bool is_warning, const std::string& text) {
  foxglove::Log log;
  ToFoxglove(time_ns, log.mutable_timestamp());
  log.set_level(is_warning ? foxglove::Log::WARNING : foxglove::Log::INFO);
  log.set_message(EscapeText(text));
  log.set_name(kName);
  return channels_.Write(kLogTopic, time_ns, log);
}

absl::Status MissionRecording::End(const ToldMap& map,
                                   const std::vector<RecordedTrajectory>& trajectories) {
  for (const RecordedTrajectory& trajectory : trajectories) {
    if (map.islands.contains(trajectory.island)) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "the trajectory of robot ", EscapeName(trajectory.robot), " is of island ",
        ToString(trajectory.island), ", which the map has not: it was fused meanwhile, try again"));
  }
  RETURN_IF_ERROR(WritePoints(map, mission_.colours, LastMomentAt_ns(), channels_));
  RETURN_IF_ERROR(WriteNotes(std::numeric_limits<uint64_t>::max()));
  RETURN_IF_ERROR(Note(DriveAt_ns(), /*is_warning=*/false,
                       "robots drive again in the map as it is, each by its own clock since its "
                       "first frame"));
  RETURN_IF_ERROR(
      WriteTrajectories(trajectories, mission_.frame_of_robots, DriveAt_ns(), channels_));
  return WriteMetadata(map, trajectories);
}

absl::Status MissionRecording::WriteMetadata(const ToldMap& map,
                                             const std::vector<RecordedTrajectory>& trajectories) {
  McapWriter::Metadata metadata = {
      {"mission", EscapeName(mission_.mission)},
      {"revision", absl::StrCat(map.revision)},
      {"clock",
       "the recording's own: a second a told moment from second 1 on, then the robots, "
       "each by its own clock since its first frame"},
      {"moments", absl::StrCat(moments_)},
      {"drive_begins_ns", absl::StrCat(DriveAt_ns())},
      {"poses_of", mission_.frame_of_robots}};
  for (const auto& [robot, colour] : mission_.colours) {
    metadata[absl::StrCat("colour/", EscapeName(robot))] = ToString(colour);
  }
  for (const RecordedTrajectory& trajectory : trajectories) {
    const std::string name =
        absl::StrCat(EscapeName(trajectory.robot), NumberSuffix(trajectory.drive));
    metadata[absl::StrCat("first_frame_ns/", name)] = absl::StrCat(trajectory.drive_begins_ns);
  }
  return channels_.writer().AddMetadata(kName, metadata);
}

absl::Status MissionRecording::Finish() { return channels_.writer().Finish(); }

}  // namespace corbslam::services
