#include <memory>
#include <set>
#include <utility>

#include "services/client/store/store_reader.h"
#include "services/convert/resource_names.h"
#include "services/security/flags.h"
#include "services/tool/commands/commands.h"
#include "services/tool/evaluation/accuracy.h"
#include "services/tool/evaluation/picture.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;

namespace {

struct RenderArguments {
  std::string server;
  std::string mission = "demo";
  std::string own;
  std::string truth;
  std::string out = "map.png";
  MapPictureOptions picture;
  SecurityOptions security;
};

std::vector<std::string> ListAgents(const ServedMap& map) {
  std::set<std::string> agents;
  for (const ServedMap::Keyframe& keyframe : map.keyframes) agents.insert(keyframe.agent);
  return {agents.begin(), agents.end()};
}

// Aligns the truth of one sequence to the robots that lie in the global frame.
absl::StatusOr<FusedAccuracy> AlignTruth(StoreReader& store, const std::vector<std::string>& agents,
                                         const std::string& truth) {
  if (truth.empty()) return FusedAccuracy{};
  ASSIGN_OR_RETURN(const SourceSpec source, ParseSourceSpec(truth));
  std::vector<RobotPaths> robots;
  for (const std::string& agent : agents) {
    RobotPaths& paths = robots.emplace_back();
    paths.name = agent;
    paths.source = source;
    ASSIGN_OR_RETURN(paths.local, store.ReadTrajectory(agent, v1::TRAJECTORY_FRAME_LOCAL));
    ASSIGN_OR_RETURN(paths.global, store.ReadTrajectory(agent, v1::TRAJECTORY_FRAME_GLOBAL));
  }
  ASSIGN_OR_RETURN(Accuracy accuracy, ComputeAccuracy(robots, 0, Alignment::kSe3));
  return std::move(accuracy.fused);
}

absl::Status Render(const RenderArguments& arguments) {
  RETURN_IF_ERROR(CheckNameSegment("--mission", arguments.mission));
  ASSIGN_OR_RETURN(const std::shared_ptr<grpc::Channel> channel,
                   ConnectToStore(arguments.server, arguments.security));
  StoreReader store(channel, arguments.mission);
  // Without keyframes a mission has no map to wait for.
  ASSIGN_OR_RETURN(const v1::GetStatisticsResponse statistics, store.Statistics());
  ServedMap map;
  if (statistics.mission().islands_size() > 0) {
    ASSIGN_OR_RETURN(map, store.ReadGlobalMap());
  }
  if (map.keyframes.empty()) {
    return absl::NotFoundError("mission " + arguments.mission + " has no keyframes yet");
  }
  const std::vector<std::string> agents = ListAgents(map);
  ASSIGN_OR_RETURN(const std::string own, ChooseOwn(arguments.own, agents));
  ASSIGN_OR_RETURN(const FusedAccuracy accuracy, AlignTruth(store, agents, arguments.truth));
  ASSIGN_OR_RETURN(const cv::Mat image,
                   RenderMap(ComposePicture(map, own, accuracy), arguments.picture));
  return WritePng(image, arguments.out);
}

}  // namespace

void AddRenderCommand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* render = app.add_subcommand("render", "Draw a mission's global map from above");
  render->add_option("--server", arguments->server, "The map store, HOST:PORT")->required();
  render->add_option("--mission", arguments->mission)->capture_default_str();
  render->add_option("--own", arguments->own, "The robot drawn as own (the first)");
  render->add_option("--truth", arguments->truth,
                     "kitti:DIR, tum:DIR, euroc:DIR or sim:WORLD, drawn dashed");
  render->add_option("--width", arguments->picture.width_px, "Pixels")->capture_default_str();
  render->add_option("--out", arguments->out, "The PNG to write")->capture_default_str();
  AddTlsFlags(*render, arguments->security);
  AddClientFlags(*render, arguments->security);
  render->callback([arguments, &chosen] { chosen = [arguments] { return Render(*arguments); }; });
}

}  // namespace corbslam::services
