#include <cstdio>
#include <limits>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/durable/mission_archive.h"
#include "services/convert/resource_names.h"
#include "services/corbslam/mission_admin.h"
#include "services/corbslam/mission_arguments.h"
#include "services/corbslam/mission_summary.h"
#include "services/corbslam/store_reader.h"
#include "services/mission_export/colmap_model.h"
#include "services/mission_export/euroc_file.h"
#include "services/mission_export/ply_file.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/folders.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

absl::Status WriteTimes(const Trajectory& trajectory, const std::string& path) {
  std::vector<std::string> lines;
  for (const StampedPose& pose : trajectory) lines.push_back(FormatSeconds(pose.timestamp_ns));
  return WriteLines(lines, path);
}

absl::Status WriteTrajectory(const Trajectory& trajectory, const std::string& format,
                             const std::string& path) {
  if (format == "tum") return WriteTumTrajectory(trajectory, path);
  if (format == "euroc") return WriteEurocTrajectory(trajectory, path);
  RETURN_IF_ERROR(WriteKittiTrajectory(trajectory, path));
  return WriteTimes(trajectory, path + ".times");
}

absl::Status ExportTrajectory(const MissionArguments& arguments, StoreReader& store,
                              const std::string& agent, const std::string& path) {
  ASSIGN_OR_RETURN(const ServedTrajectory served,
                   store.ReadTrajectory(agent, v1::TRAJECTORY_FRAME_GLOBAL));
  if (served.empty() && !arguments.agent.empty()) {
    return absl::NotFoundError(
        absl::StrCat("robot ", agent, ": nothing of it is connected to the global frame"));
  }
  if (served.empty()) {
    std::printf("%s: nothing of it is connected to the global frame\n", agent.c_str());
    return absl::OkStatus();
  }
  RETURN_IF_ERROR(WriteTrajectory(ToTrajectory(served), arguments.format, path));
  std::printf("%s: %zu poses of %s\n", path.c_str(), served.size(), agent.c_str());
  return absl::OkStatus();
}

// One robot's into the file, or everybody's into files of a folder.
absl::Status ExportTrajectories(const MissionArguments& arguments,
                                const std::shared_ptr<grpc::Channel>& channel) {
  StoreReader store(channel, arguments.mission);
  if (!arguments.agent.empty()) {
    RETURN_IF_ERROR(CheckNameSegment("--agent", arguments.agent));
    return ExportTrajectory(arguments, store, arguments.agent, arguments.file);
  }
  ASSIGN_OR_RETURN(const auto agents, ReadAgents(channel, arguments.mission));
  RETURN_IF_ERROR(MakeFolder(arguments.file));
  const std::string ending = arguments.format == "euroc" ? ".csv" : ".txt";
  for (const v1::MissionAgent& agent : agents) {
    const std::string name = LastSegment(agent.name());
    RETURN_IF_ERROR(
        ExportTrajectory(arguments, store, name, absl::StrCat(arguments.file, "/", name, ending)));
  }
  return absl::OkStatus();
}

absl::Status ExportPoints(const MissionArguments& arguments,
                          const std::shared_ptr<grpc::Channel>& channel) {
  ASSIGN_OR_RETURN(const auto agents, ReadAgents(channel, arguments.mission));
  std::set<std::string> names;
  for (const v1::MissionAgent& agent : agents) names.insert(LastSegment(agent.name()));
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
    // One that has joined since is drawn as nobody's.
    const auto colour = colours.find(map.point_agents[i]);
    points.push_back({map.points[i], colour == colours.end() ? Colour{} : colour->second});
  }
  std::vector<std::string> comments;
  for (const auto& [agent, colour] : colours) {
    if (!arguments.agent.empty() && agent != arguments.agent) continue;
    comments.push_back(absl::StrCat("robot ", agent, " ", ToString(colour)));
    std::printf("%s\n", comments.back().c_str());
  }
  RETURN_IF_ERROR(WritePly(points, comments, arguments.file));
  std::printf("%s: %zu points\n", arguments.file.c_str(), points.size());
  return absl::OkStatus();
}

// All that the store has: no other call tells which keypoint sees which point.
absl::StatusOr<map_store::MissionState> ReadState(const MissionArguments& arguments,
                                                  const std::shared_ptr<grpc::Channel>& channel) {
  MissionAdmin admin(channel);
  MissionRestorer restorer(std::numeric_limits<uint64_t>::max());
  const auto show = ShowBytes("read");
  uint64_t bytes = 0;
  RETURN_IF_ERROR(admin.ReadBackup(arguments.mission, [&](const std::string& piece) {
    bytes += piece.size();
    if (show != nullptr) show(bytes);
    return restorer.Add(piece);
  }));
  return restorer.Finish();
}

absl::Status ExportColmap(const MissionArguments& arguments,
                          const std::shared_ptr<grpc::Channel>& channel) {
  if (!arguments.agent.empty()) {
    return absl::InvalidArgumentError("--agent: a COLMAP model is of all robots");
  }
  ASSIGN_OR_RETURN(const map_store::MissionState state, ReadState(arguments, channel));
  ASSIGN_OR_RETURN(const Map map, GlobalMapOf(state));
  std::map<LocalMapId, std::string> robots;
  for (const auto& [id, local_map] : state.local_maps) robots[id] = local_map.agent;
  ASSIGN_OR_RETURN(const ColmapCounts counts, WriteColmapModel(map, robots, arguments.file));
  std::printf("%s: %zu cameras, %zu images, %zu points, %zu observations\n", arguments.file.c_str(),
              counts.cameras, counts.images, counts.points, counts.observations);
  return absl::OkStatus();
}

absl::Status Export(const MissionArguments& arguments) {
  RETURN_IF_ERROR(CheckNameSegment("--mission", arguments.mission));
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  // What follows finds nothing where there is no keyframe; say so at once.
  ASSIGN_OR_RETURN(const v1::GetStatisticsResponse statistics,
                   StoreReader(channel, arguments.mission).Statistics());
  if (statistics.mission().keyframes() == 0) {
    return absl::NotFoundError("mission " + arguments.mission + " has no keyframes yet");
  }
  if (arguments.format == "colmap") return ExportColmap(arguments, channel);
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
      ->add_option("--format", arguments->format,
                   "tum, kitti (its times beside it, in FILE.times), euroc: trajectories; ply: "
                   "points coloured by robot; colmap: a text model (operators only)")
      ->check(CLI::IsMember({"tum", "kitti", "euroc", "ply", "colmap"}))
      ->required();
  action
      ->add_option("--out", arguments->file,
                   "File to write; a folder for colmap, and for trajectories without --agent")
      ->required();
  action->add_option("--agent", arguments->agent, "Only this robot's");
}

}  // namespace corbslam
