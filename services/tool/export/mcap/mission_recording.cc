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
// Some programs take time 0 for no time.
constexpr uint64_t kBegin_ns = kSecond_ns;
// Of all moments' points: 256 MB.
constexpr size_t kMostPoints = 16'000'000;
// Of frusta while no two keyframes have shown how far apart they usually are.
constexpr double kFirstFrustumDepth = 0.1;

// Turns a camera's axes (x right, y down, z forward) so that z points up.
Rigid3d UprightFromMission() {
  const double half = std::sqrt(0.5);
  return {Eigen::Quaterniond(half, -half, 0, 0), Eigen::Vector3d::Zero()};
}

absl::Status CheckIslands(const ToldMap& map, const std::vector<RecordedTrajectory>& trajectories) {
  for (const RecordedTrajectory& trajectory : trajectories) {
    if (map.islands.contains(trajectory.island)) continue;
    return absl::FailedPreconditionError(absl::StrCat(
        "the trajectory of robot ", EscapeName(trajectory.robot), " is of island ",
        ToString(trajectory.island), ", which the map has not: it was fused meanwhile, try again"));
  }
  return absl::OkStatus();
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

MissionRecording::MissionRecording(RecordedMission mission, McapWriter writer)
    : mission_(std::move(mission)), channels_(std::move(writer)), now_ns_(kBegin_ns) {}

absl::Status MissionRecording::BeginDrives(const ToldMap& map,
                                           std::vector<RecordedTrajectory> trajectories) {
  RETURN_IF_ERROR(CheckIslands(map, trajectories));
  ASSIGN_OR_RETURN(drives_,
                   TrajectoryPlayer::Create(std::move(trajectories), mission_.frame_of_robots,
                                            mission_.colours, std::nullopt));
  if (const auto first_ns = drives_->first_ns(); first_ns.has_value()) now_ns_ = *first_ns;
  // Robots have moved before the first moment.
  return WriteFrames(map);
}

uint64_t MissionRecording::TimeOf(const ToldMap& map) const {
  int64_t newest_ns = 0;
  for (const auto& [id, island] : map.islands) {
    for (const auto& [keyframe, unused] : island.keyframes) {
      const auto time = mission_.keyframe_times_ns.find(keyframe);
      if (time != mission_.keyframe_times_ns.end()) newest_ns = std::max(newest_ns, time->second);
    }
  }
  // Nothing comes before what was written.
  return std::max(now_ns_, static_cast<uint64_t>(newest_ns));
}

bool MissionRecording::TakesPoints(const ToldMap& map) {
  size_t points = 0;
  for (const auto& [id, island] : map.islands) points += island.points.size();
  points_left_ += kMostPoints / std::max<size_t>(1, mission_.expected_moments);
  if (points == 0 || points > points_left_) return false;
  points_left_ -= points;
  return true;
}

absl::Status MissionRecording::AddMoment(const ToldMap& map) {
  ++moments_;
  now_ns_ = IsOnOwnClock() ? moments_ * kSecond_ns : TimeOf(map);
  if (drives_.has_value()) RETURN_IF_ERROR(drives_->PlayUntil(now_ns_, channels_));
  if (!frustum_depth_.has_value()) frustum_depth_ = ChooseFrustumDepth(map);
  RETURN_IF_ERROR(WriteFrames(map));
  RETURN_IF_ERROR(WriteKeyframes(map, mission_.colours, frustum_depth_.value_or(kFirstFrustumDepth),
                                 now_ns_, channels_));
  RETURN_IF_ERROR(WriteOverlaps(map, mission_.overlaps, now_ns_, channels_));
  if (!IsOnOwnClock() && TakesPoints(map)) {
    RETURN_IF_ERROR(WritePoints(map, mission_.colours, now_ns_, channels_));
  }
  RETURN_IF_ERROR(Note(
      now_ns_, /*is_warning=*/false,
      absl::StrCat("the map at revision ", map.revision, ": ", map.CountKeyframes(), " keyframes, ",
                   map.islands.size(), map.islands.size() == 1 ? " island" : " islands")));
  return WriteNotes(map.revision);
}

absl::Status MissionRecording::WriteFrames(const ToldMap& map) {
  const uint64_t time_ns = now_ns_;
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
    RETURN_IF_ERROR(Note(now_ns_, note.is_warning, note.text));
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
                                   std::vector<RecordedTrajectory> trajectories) {
  RETURN_IF_ERROR(CheckIslands(map, trajectories));
  RETURN_IF_ERROR(WritePoints(map, mission_.colours, now_ns_, channels_));
  RETURN_IF_ERROR(WriteNotes(std::numeric_limits<uint64_t>::max()));
  if (IsOnOwnClock()) {
    drive_at_ns_ = now_ns_ + kSecond_ns;
    RETURN_IF_ERROR(Note(drive_at_ns_, /*is_warning=*/false,
                         "robots drive again in the map as it is, each by its own clock since its "
                         "first frame"));
    ASSIGN_OR_RETURN(drives_,
                     TrajectoryPlayer::Create(std::move(trajectories), mission_.frame_of_robots,
                                              mission_.colours, drive_at_ns_));
  }
  if (drives_.has_value()) {
    RETURN_IF_ERROR(drives_->PlayUntil(std::numeric_limits<uint64_t>::max(), channels_));
  }
  return WriteMetadata(map);
}

absl::Status MissionRecording::WriteMetadata(const ToldMap& map) {
  McapWriter::Metadata metadata = {
      {"mission", EscapeName(mission_.mission)},
      {"revision", absl::StrCat(map.revision)},
      {"clock", IsOnOwnClock()
                    ? "the recording's own: a second a told moment from second 1 on, then the "
                      "robots, each by its own clock since its first frame"
                    : "the robots' own: poses have their frames' times, a told moment has that of "
                      "its newest keyframe"},
      {"moments", absl::StrCat(moments_)},
      {"poses_of", mission_.frame_of_robots}};
  if (IsOnOwnClock()) metadata["drive_begins_ns"] = absl::StrCat(drive_at_ns_);
  for (const auto& [robot, colour] : mission_.colours) {
    metadata[absl::StrCat("colour/", EscapeName(robot))] = ToString(colour);
  }
  static const std::vector<RecordedTrajectory> none;
  for (const RecordedTrajectory& trajectory : drives_ ? drives_->trajectories() : none) {
    const std::string name = absl::StrCat(EscapeName(trajectory.robot), trajectory.suffix);
    metadata[absl::StrCat("first_frame_ns/", name)] = absl::StrCat(trajectory.drive_begins_ns);
  }
  return channels_.writer().AddMetadata(kName, metadata);
}

absl::Status MissionRecording::Finish() { return channels_.writer().Finish(); }

}  // namespace corbslam::services
