#include "services/tool/commands/export_mcap.h"

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/client/store/store_reader.h"
#include "services/convert/resource_names.h"
#include "services/tool/commands/recorded_notes.h"
#include "services/tool/evaluation/trajectory_files.h"
#include "services/tool/export/mcap/mission_recording.h"
#include "services/tool/export/robot_colours.h"
#include "services/tool/mission/mission_summary.h"
#include "services/tool/output/result.h"
#include "slam/evaluation/pose_header.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// What happens to a call that an older store does not know.
bool IsUnknownCall(const absl::Status& status) {
  return status.code() == absl::StatusCode::kUnimplemented;
}

absl::StatusOr<std::vector<RecordedNote>> CollectNotes(StoreReader& store,
                                                       const MissionSummary& summary) {
  std::vector<RecordedNote> notes = NotesOfOverlaps(summary);
  const absl::StatusOr<std::vector<v1::MissionEvent>> events = store.ReadEvents();
  if (IsUnknownCall(events.status())) {
    Say("the map store is older than this program and tells no events\n");
    return notes;
  }
  RETURN_IF_ERROR(events.status());
  const std::vector<RecordedNote> of_events = NotesOfEvents(*events, summary);
  notes.insert(notes.end(), of_events.begin(), of_events.end());
  return notes;
}

absl::StatusOr<RecordedMission> Collect(const MissionArguments& arguments, StoreReader& store,
                                        const MissionSummary& summary) {
  RecordedMission mission;
  mission.mission = arguments.mission;
  std::set<std::string> robots;
  for (const v1::MissionAgent& agent : summary.agents) robots.insert(LastSegment(agent.name()));
  mission.colours = ChooseColours(robots);
  ASSIGN_OR_RETURN(mission.overlaps, AcceptedOverlaps(summary));
  ASSIGN_OR_RETURN(mission.notes, CollectNotes(store, summary));
  mission.frame_of_robots = arguments.poses_of.empty() ? "camera" : arguments.poses_of;
  return mission;
}

// Writes the past. A change that was told behind its last moment makes one more.
absl::StatusOr<ToldMap> RecordPast(const MissionArguments& arguments, StoreReader& store,
                                   MissionRecording& recording) {
  uint64_t told = 0;
  const absl::Status status =
      store.ReplayMap(arguments.moments, [&](const ToldMap& map) -> absl::Status {
        told = map.version;
        return recording.AddMoment(map);
      });
  if (IsUnknownCall(status)) {
    Say("the map store is older than this program and tells no past: the map is as it is\n");
  } else if (status.code() == absl::StatusCode::kResourceExhausted) {
    return absl::ResourceExhaustedError(
        absl::StrCat(status.message(), "; --moments says how many"));
  } else {
    RETURN_IF_ERROR(status);
  }
  ASSIGN_OR_RETURN(ToldMap map, store.ReadMap());
  if (recording.moments() == 0 || map.version != told) {
    RETURN_IF_ERROR(recording.AddMoment(map));
  }
  return map;
}

// Adds a robot's drives, each island's part of them on its own.
absl::Status AddDrives(const std::string& robot, const ServedTrajectory& served, const ToldMap& map,
                       std::vector<RecordedTrajectory>& trajectories) {
  size_t drive = 0;
  for (const TrajectoryFile& parts : ShareFiles(PartsOf(served))) {
    ++drive;
    std::map<LocalMapId, RecordedTrajectory> by_island;
    for (const TrajectoryPart& part : parts) {
      if (part.poses.empty()) continue;
      ASSIGN_OR_RETURN(const LocalMapPath path, ParseLocalMapName(part.island, false));
      const LocalMapId island = path.local_map;
      const auto known = map.islands.find(island);
      RecordedTrajectory& trajectory = by_island[island];
      trajectory.robot = robot;
      trajectory.drive = drive;
      trajectory.island = island;
      trajectory.in_global_frame = known != map.islands.end() && known->second.in_global_frame;
      trajectory.drive_begins_ns = parts.front().poses.front().timestamp_ns;
      trajectory.poses.insert(trajectory.poses.end(), part.poses.begin(), part.poses.end());
    }
    for (auto& [island, trajectory] : by_island) trajectories.push_back(std::move(trajectory));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<RecordedTrajectory>> ReadDrives(const MissionSummary& summary,
                                                           PosesOf poses_of, const ToldMap& map,
                                                           StoreReader& store) {
  std::vector<RecordedTrajectory> trajectories;
  for (const v1::MissionAgent& agent : summary.agents) {
    const std::string robot = LastSegment(agent.name());
    ASSIGN_OR_RETURN(const ServedTrajectory served,
                     store.ReadTrajectory(robot, v1::TRAJECTORY_FRAME_GLOBAL, poses_of,
                                          StoreReader::Reach::kAllIslands));
    RETURN_IF_ERROR(AddDrives(robot, served, map, trajectories));
  }
  return trajectories;
}

absl::Status WriteReadmeOf(const MissionArguments& arguments, PosesOf poses_of,
                           const MissionRecording& recording) {
  return WriteReadme(
      {absl::StrCat("Recording of mission ", arguments.mission, " for Foxglove and Rerun: ",
                    recording.moments(), " moments of the map, a second each,"),
       "then the robots driving again in the map as it is, each by its own clock since its first "
       "frame.",
       absl::StrCat("Robots' poses: ", PoseHeaderLine(poses_of), ";"),
       "frames and topics are listed in CORB-SLAM's docs/operations.md; metres."},
      arguments.file);
}

}  // namespace

absl::Status ExportMcap(const MissionArguments& arguments,
                        const std::shared_ptr<grpc::Channel>& channel) {
  if (!arguments.agent.empty()) {
    return absl::InvalidArgumentError("--agent: a recording is of all robots");
  }
  ASSIGN_OR_RETURN(const PosesOf poses_of,
                   ParsePosesOf(arguments.poses_of.empty() ? "camera" : arguments.poses_of));
  StoreReader store(channel, arguments.mission);
  ASSIGN_OR_RETURN(const MissionSummary summary, ReadSummary(channel, arguments.mission));
  ASSIGN_OR_RETURN(RecordedMission mission, Collect(arguments, store, summary));
  ASSIGN_OR_RETURN(MissionRecording recording,
                   MissionRecording::Create(arguments.file, std::move(mission)));
  ASSIGN_OR_RETURN(const ToldMap map, RecordPast(arguments, store, recording));
  ASSIGN_OR_RETURN(const auto trajectories, ReadDrives(summary, poses_of, map, store));
  RETURN_IF_ERROR(recording.End(map, trajectories));
  RETURN_IF_ERROR(recording.Finish());
  RETURN_IF_ERROR(WriteReadmeOf(arguments, poses_of, recording));
  PrintResult(absl::StrCat(arguments.file, ": ", recording.moments(), " moments, ",
                           map.CountKeyframes(), " keyframes\n"),
              {{"file", arguments.file},
               {"moments", recording.moments()},
               {"keyframes", map.CountKeyframes()}});
  return absl::OkStatus();
}

}  // namespace corbslam::services
