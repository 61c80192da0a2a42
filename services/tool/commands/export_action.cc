#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/archive/mission_archive.h"
#include "services/client/store/store_reader.h"
#include "services/convert/resource_names.h"
#include "services/tool/commands/export_mcap.h"
#include "services/tool/commands/export_trajectories.h"
#include "services/tool/commands/mission_arguments.h"
#include "services/tool/export/colmap_model.h"
#include "services/tool/export/ply_file.h"
#include "services/tool/mission/mission_admin.h"
#include "services/tool/mission/mission_summary.h"
#include "services/tool/output/progress.h"
#include "services/tool/output/result.h"
#include "slam/camera/recorded_camera.h"
#include "slam/evaluation/pose_header.h"
#include "slam/util/atomic_file.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {

using map_store::MissionRestorer;

namespace {

// Counts the points that are not connected to the global frame; of all robots where `agent` is
// empty.
size_t PointsElsewhere(const ServedMap& map, const std::string& agent) {
  size_t points = 0;
  for (const auto& [made_by, count] : map.elsewhere.points) {
    if (agent.empty() || made_by == agent) points += count;
  }
  return points;
}

// Returns "" if nothing is left out.
std::string DescribeLeftOut(const ServedMap& map, const std::string& agent) {
  const size_t points = PointsElsewhere(map, agent);
  if (points == 0) return "";
  return absl::StrCat("without ", points,
                      " points of islands that nothing connects with the global ",
                      "frame: ", Describe(map.elsewhere));
}

absl::Status ExportPoints(const MissionArguments& arguments,
                          const std::shared_ptr<grpc::Channel>& channel) {
  ASSIGN_OR_RETURN(const auto agents, ReadAgents(channel, arguments.mission));
  std::set<std::string> names;
  for (const v1::MissionAgent& agent : agents) names.insert(LastSegment(agent.name()));
  if (!arguments.poses_of.empty()) {
    return absl::InvalidArgumentError("--poses-of: a PLY file holds points and no poses");
  }
  if (!arguments.agent.empty() && !names.contains(arguments.agent)) {
    return absl::NotFoundError(
        absl::StrCat("mission ", arguments.mission, " has no robot ", arguments.agent));
  }
  StoreReader store(channel, arguments.mission);
  ASSIGN_OR_RETURN(const ServedMap map, store.ReadGlobalMap());
  const auto colours = ChooseColours(names);
  std::vector<ColouredPoint> points;
  for (size_t i = 0; i < map.points.size(); ++i) {
    if (!arguments.agent.empty() && map.point_agents[i] != arguments.agent) continue;
    // A robot that has joined since has no colour of its own: its points get the default one.
    const auto colour = colours.find(map.point_agents[i]);
    points.push_back({map.points[i], colour == colours.end() ? Colour{} : colour->second});
  }
  if (points.empty() && !arguments.agent.empty()) {
    return absl::NotFoundError(
        absl::StrCat("no point of robot ", arguments.agent, " is connected to the global frame (",
                     PointsElsewhere(map, arguments.agent), " lie elsewhere)"));
  }
  std::vector<std::string> comments;
  for (const auto& [agent, colour] : colours) {
    if (!arguments.agent.empty() && agent != arguments.agent) continue;
    comments.push_back(absl::StrCat("robot ", agent, " ", ToString(colour)));
  }
  const std::string left_out = DescribeLeftOut(map, arguments.agent);
  if (!left_out.empty()) comments.push_back(left_out);
  for (const std::string& comment : comments) Say(comment + "\n");
  RETURN_IF_ERROR(WritePly(points, comments, arguments.file));
  std::vector<std::string> readme = {
      absl::StrCat("Landmarks of mission ", arguments.mission,
                   ", coloured by the robot that made them (the PLY's comments say which),"),
      "in the mission's global frame, that of its first local map; metres."};
  if (!left_out.empty()) readme.push_back(left_out);
  RETURN_IF_ERROR(WriteReadme(readme, arguments.file));
  PrintResult(absl::StrCat(arguments.file, ": ", points.size(), " points\n"),
              {{"file", arguments.file},
               {"points", points.size()},
               {"points_left_out", PointsElsewhere(map, arguments.agent)}});
  return absl::OkStatus();
}

// Reads all that the store has: no other call tells which keypoint sees which point.
absl::StatusOr<map_store::MissionState> ReadState(const MissionArguments& arguments,
                                                  const std::shared_ptr<grpc::Channel>& channel) {
  MissionAdmin admin(channel);
  MissionRestorer restorer(std::numeric_limits<uint64_t>::max());
  const std::function<void(uint64_t)> show = ShowBytes("read");
  uint64_t bytes = 0;
  RETURN_IF_ERROR(admin.ReadBackup(arguments.mission, [&](const std::string& piece) {
    bytes += piece.size();
    show(bytes);
    return restorer.Add(piece);
  }));
  return restorer.Finish();
}

// Counts the keyframes that are in no island with the global frame.
size_t KeyframesElsewhere(const map_store::MissionState& state) {
  size_t keyframes = 0;
  for (const auto& [id, island] : state.global.islands) {
    if (id == state.ReferenceIsland()) continue;
    for (const LocalMapId local_map : island.local_maps) {
      keyframes += state.local_maps.at(local_map).map.keyframes().size();
    }
  }
  return keyframes;
}

absl::Status WriteColmapReadme(const std::string& mission, const ColmapSource& source,
                               size_t left_out, const std::string& folder) {
  return WriteLines(
      {absl::StrCat("Mission ", mission,
                    " as COLMAP's text model: ", PoseHeaderLine(source.poses_of), ","),
       "in the mission's global frame, that of its first local map; metres.",
       source.poses_of == PosesOf::kRecordedCamera
           ? "Pictures are the recorded left ones, cameras have their distortion: link each robot's"
           : "Pictures are the left ones undistorted and rectified, which nobody wrote: link each",
       "to images/ROBOT/NANOSECONDS.png, called after its time. ROBOT+4 holds those of local map "
       "ROBOT/4",
       "(as `mission show` calls it) of times that ROBOT has already: the robot saw them again.",
       absl::StrCat(left_out,
                    " keyframes that nothing connects with the global frame are left out.")},
      folder + "/README.md");
}

absl::Status ExportColmap(const MissionArguments& arguments,
                          const std::shared_ptr<grpc::Channel>& channel) {
  if (!arguments.agent.empty()) {
    return absl::InvalidArgumentError("--agent: a COLMAP model is of all robots");
  }
  ASSIGN_OR_RETURN(const PosesOf poses_of,
                   ParsePosesOf(arguments.poses_of.empty() ? "camera" : arguments.poses_of));
  if (poses_of == PosesOf::kBody) {
    return absl::InvalidArgumentError(
        "--poses-of body: a COLMAP model's poses are those of its pictures' camera");
  }
  ASSIGN_OR_RETURN(const map_store::MissionState state, ReadState(arguments, channel));
  ASSIGN_OR_RETURN(const Map map, GlobalMapOf(state));
  const ColmapSource source = ColmapSourceOf(state, poses_of);
  ASSIGN_OR_RETURN(const ColmapCounts counts, WriteColmapModel(map, source, arguments.file));
  const size_t left_out = KeyframesElsewhere(state);
  RETURN_IF_ERROR(WriteColmapReadme(arguments.mission, source, left_out, arguments.file));
  if (left_out > 0) {
    Say(absl::StrCat("without ", left_out,
                     " keyframes that nothing connects with the global frame\n"));
  }
  PrintResult(
      absl::StrCat(arguments.file, ": ", counts.cameras, " cameras, ", counts.images, " images, ",
                   counts.points, " points, ", counts.observations, " observations\n"),
      {{"file", arguments.file},
       {"cameras", counts.cameras},
       {"images", counts.images},
       {"points", counts.points},
       {"observations", counts.observations},
       {"keyframes_left_out", left_out}});
  return absl::OkStatus();
}

absl::Status Export(const MissionArguments& arguments) {
  RETURN_IF_ERROR(CheckNameSegment("--mission", arguments.mission));
  if (arguments.moments != 0 && arguments.format != "mcap") {
    return absl::InvalidArgumentError(absl::StrCat(
        "--moments: ", arguments.format, " holds the map as it is; only mcap holds its past"));
  }
  // It may be standard output itself.
  if (!IsForPlainFile(arguments.file)) PrintToStandardError();
  if (!arguments.clock.empty() && arguments.format != "mcap") {
    return absl::InvalidArgumentError(absl::StrCat("--clock: ", arguments.format,
                                                   " has each robot's own; only mcap has another"));
  }
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  // The exports below find nothing where there is no keyframe; the message here says so at once.
  ASSIGN_OR_RETURN(const v1::GetStatisticsResponse statistics,
                   StoreReader(channel, arguments.mission).Statistics());
  if (statistics.mission().keyframes() == 0) {
    return absl::NotFoundError("mission " + arguments.mission + " has no keyframes yet");
  }
  if (arguments.format == "colmap") return ExportColmap(arguments, channel);
  const ProgressTicker ticker(absl::StrCat("exports ", arguments.format));
  if (arguments.format == "mcap") return ExportMcap(arguments, channel);
  if (arguments.format == "ply") return ExportPoints(arguments, channel);
  return ExportTrajectories(arguments, channel);
}

}  // namespace

void AddExportAction(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                     Command& chosen) {
  CLI::App* action = AddMissionAction(
      mission, "export", "Write trajectories or the map for other programs (a store's own: backup)",
      &Export, arguments, chosen);
  AddMissionFlag(*action, *arguments);
  action
      ->add_option(
          "--format", arguments->format,
          "tum, kitti (its times beside it, in FILE.times), euroc: trajectories; ply: "
          "points coloured by robot; colmap: a text model (operators only); mcap: the past "
          "and the robots' drives, for Foxglove and Rerun")
      ->check(CLI::IsMember({"tum", "kitti", "euroc", "ply", "colmap", "mcap"}))
      ->required();
  action
      ->add_option("--out", arguments->file,
                   "File to write; a folder for colmap, and for trajectories without --agent")
      ->required();
  action
      ->add_option("--moments", arguments->moments,
                   "mcap: of the map's past at most so many moments, 2 to 1000 (default: 100)")
      ->check(CLI::Range(2, 1000));
  action
      ->add_option(
          "--clock", arguments->clock,
          "mcap: robots (the default): each pose has its frame's time, and the recording "
          "lies beside others of the robots; recording: a second a moment, then all drives "
          "begin together")
      ->check(CLI::IsMember({"robots", "recording"}));
  action->add_option("--agent", arguments->agent, "Only this robot's");
  action
      ->add_option("--poses-of", arguments->poses_of,
                   "camera (as recorded; of a stereo pair the left one, the default), rectified "
                   "(the rectified camera) or body (where the robots know it)")
      ->check(CLI::IsMember({"camera", "rectified", "body"}));
}

}  // namespace corbslam::services
