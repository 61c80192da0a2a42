#include "services/tool/commands/export_mcap.h"

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/client/store/local_map_names.h"
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

constexpr char kOwnClock[] = "recording";

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
  if (arguments.clock != kOwnClock) {
    mission.clock = RecordingClock::kRobots;
    ASSIGN_OR_RETURN(mission.keyframe_times_ns, store.ReadKeyframeTimes());
    if (arguments.moments > 0) mission.expected_moments = arguments.moments;
  }
  return mission;
}

// Writes the past. A change that was told behind its last moment makes one more.
absl::StatusOr<ToldMap> RecordPast(const MissionArguments& arguments, StoreReader& store,
                                   MissionRecording& recording) {
  uint64_t told = 0;
  const auto add = [&](const ToldMap& map) -> absl::Status {
    told = map.version;
    return recording.AddMoment(map);
  };
  bool with_points = arguments.clock != kOwnClock;
  absl::Status status = store.ReplayMap(arguments.moments, with_points, add);
  if (with_points && absl::IsResourceExhausted(status) && recording.moments() == 0) {
    Say("the past with its points is more than the map store tells at once: points are those of "
        "the "
        "end alone\n");
    with_points = false;
    status = store.ReplayMap(arguments.moments, with_points, add);
  }
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

// The frames, by local map and time, that nothing connects with the one before.
using Gaps = std::set<std::pair<std::string, int64_t>>;

Gaps GapsOf(const ServedTrajectory& served) {
  Gaps gaps;
  for (const ServedPose& pose : served) {
    if (pose.after_gap) gaps.emplace(pose.local_map, pose.timestamp_ns);
  }
  return gaps;
}

// Appends a part's poses, and where its pieces begin.
void AddPart(const TrajectoryPart& part, const Gaps& gaps, RecordedTrajectory& trajectory) {
  for (size_t i = 0; i < part.poses.size(); ++i) {
    const bool begins = i == 0 || gaps.contains({part.local_map, part.poses[i].timestamp_ns});
    if (begins) trajectory.pieces.push_back(trajectory.poses.size());
    trajectory.poses.push_back(part.poses[i]);
  }
}

// Adds a robot's drives, each island's part of them on its own.
absl::Status AddDrives(const std::string& robot, const ServedTrajectory& served, const ToldMap& map,
                       const LocalMapNames& names, std::vector<RecordedTrajectory>& trajectories) {
  const std::vector<TrajectoryFile> drives = ShareFiles(PartsOf(served));
  const std::vector<std::string> suffixes = SuffixesOf(drives, names);
  const Gaps gaps = GapsOf(served);
  for (size_t i = 0; i < drives.size(); ++i) {
    const TrajectoryFile& parts = drives[i];
    std::map<LocalMapId, RecordedTrajectory> by_island;
    for (const TrajectoryPart& part : parts) {
      if (part.poses.empty()) continue;
      ASSIGN_OR_RETURN(const LocalMapPath path, ParseLocalMapName(part.island, false));
      const LocalMapId island = path.local_map;
      const auto known = map.islands.find(island);
      RecordedTrajectory& trajectory = by_island[island];
      trajectory.robot = robot;
      trajectory.suffix = suffixes[i];
      trajectory.island = island;
      trajectory.in_global_frame = known != map.islands.end() && known->second.in_global_frame;
      trajectory.drive_begins_ns = parts.front().poses.front().timestamp_ns;
      AddPart(part, gaps, trajectory);
    }
    for (auto& [island, trajectory] : by_island) trajectories.push_back(std::move(trajectory));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<RecordedTrajectory>> ReadDrives(const MissionSummary& summary,
                                                           PosesOf poses_of, const ToldMap& map,
                                                           StoreReader& store) {
  std::vector<RecordedTrajectory> trajectories;
  const LocalMapNames names = ShortNames(summary.local_maps);
  for (const v1::MissionAgent& agent : summary.agents) {
    const std::string robot = LastSegment(agent.name());
    ASSIGN_OR_RETURN(const ServedTrajectory served,
                     store.ReadTrajectory(robot, v1::TRAJECTORY_FRAME_GLOBAL, poses_of,
                                          StoreReader::Reach::kAllIslands));
    RETURN_IF_ERROR(AddDrives(robot, served, map, names, trajectories));
  }
  return trajectories;
}

// Clocks that are a day apart make a recording of which nothing is seen at once.
void SayIfClocksDiffer(const std::vector<RecordedTrajectory>& trajectories) {
  constexpr int64_t kDay_ns = int64_t{86'400} * 1'000'000'000;
  for (const RecordedTrajectory& a : trajectories) {
    for (const RecordedTrajectory& b : trajectories) {
      if (b.drive_begins_ns / 2 - a.drive_begins_ns / 2 <= kDay_ns / 2) continue;
      Say(absl::StrCat("the clocks of ", a.robot, " and ", b.robot,
                       " are more than a day apart: --clock recording has both drives begin "
                       "together\n"));
      return;
    }
  }
}

absl::Status WriteReadmeOf(const MissionArguments& arguments, PosesOf poses_of,
                           const MissionRecording& recording) {
  const bool is_own = arguments.clock == kOwnClock;
  return WriteReadme(
      {absl::StrCat("Recording of mission ", arguments.mission,
                    " for Foxglove and Rerun: ", recording.moments(), " moments of the map, ",
                    is_own ? "a second each," : "each at the time of its newest keyframe,"),
       is_own
           ? "then the robots driving again in the map as it is, each by its own clock since its "
             "first frame."
           : "and the robots driving in the map as it is in the end, at their frames' own times.",
       absl::StrCat("Robots' poses: ", PoseHeaderLine(poses_of), ";"),
       "frames and topics are listed in CORB-SLAM's docs/exports.md; metres."},
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
  std::vector<RecordedTrajectory> trajectories;
  if (arguments.clock != kOwnClock) {
    ASSIGN_OR_RETURN(const ToldMap now, store.ReadMap());
    ASSIGN_OR_RETURN(trajectories, ReadDrives(summary, poses_of, now, store));
    SayIfClocksDiffer(trajectories);
    RETURN_IF_ERROR(recording.BeginDrives(now, std::move(trajectories)));
  }
  ASSIGN_OR_RETURN(const ToldMap map, RecordPast(arguments, store, recording));
  trajectories.clear();
  if (arguments.clock == kOwnClock) {
    ASSIGN_OR_RETURN(trajectories, ReadDrives(summary, poses_of, map, store));
  }
  RETURN_IF_ERROR(recording.End(map, std::move(trajectories)));
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
