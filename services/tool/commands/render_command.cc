#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "absl/algorithm/container.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "services/client/store/store_reader.h"
#include "services/convert/resource_names.h"
#include "services/security/flags.h"
#include "services/tool/commands/commands.h"
#include "services/tool/evaluation/accuracy.h"
#include "services/tool/evaluation/picture.h"
#include "services/tool/output/progress.h"
#include "services/tool/output/result.h"
#include "slam/util/atomic_file.h"
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

// Returns true for FILE.svg.
bool IsSvg(const std::string& path) { return absl::EndsWithIgnoreCase(path, ".svg"); }

// Refuses a name that is no picture's before anybody is asked.
absl::Status CheckOut(const std::string& out) {
  for (const char* ending : {".svg", ".png", ".jpg", ".jpeg", ".webp"}) {
    if (absl::EndsWithIgnoreCase(out, ending)) return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "--out ", out, ": the file must end with .svg or .png (.jpg and .webp work, too)"));
}

std::vector<std::string> ListAgents(const ServedMap& map) {
  std::set<std::string> agents;
  for (const ServedMap::Keyframe& keyframe : map.keyframes) agents.insert(keyframe.agent);
  return {agents.begin(), agents.end()};
}

// Returns INVALID_ARGUMENT if the truth has nothing to do with where the robots were: nothing would
// be drawn, and nobody told.
absl::Status CheckTruth(const std::string& truth, const std::vector<RobotPaths>& robots,
                        const FusedAccuracy& fused) {
  if (!fused.truth.has_value()) {
    return absl::NotFoundError(absl::StrCat("--truth ", truth, ": there is no ground truth in it"));
  }
  if (fused.truth_from_global.has_value()) return absl::OkStatus();
  size_t poses = 0;
  for (const RobotPaths& robot : robots) poses += robot.global.size();
  return absl::InvalidArgumentError(absl::StrCat(
      "--truth ", truth, ": fewer than 3 of the ", poses,
      " poses in the global frame have a true pose within ", kMaxAssociationGap_ns / 1'000'000,
      " ms. Is it what these robots saw, and are its times of the same clock, in seconds?"));
}

absl::StatusOr<std::vector<RobotPaths>> ReadPaths(StoreReader& store,
                                                  const std::vector<std::string>& agents) {
  std::vector<RobotPaths> robots;
  for (const std::string& agent : agents) {
    RobotPaths& paths = robots.emplace_back();
    paths.name = agent;
    ASSIGN_OR_RETURN(paths.global, store.ReadTrajectory(agent, v1::TRAJECTORY_FRAME_GLOBAL));
  }
  return robots;
}

// Aligns the truth of one sequence to the robots that lie in the global frame.
absl::StatusOr<FusedAccuracy> AlignTruth(StoreReader& store, std::vector<RobotPaths> robots,
                                         const std::string& truth) {
  if (truth.empty()) return FusedAccuracy{};
  ASSIGN_OR_RETURN(const SourceSpec source, ParseSourceSpec(truth));
  for (RobotPaths& paths : robots) {
    paths.source = source;
    ASSIGN_OR_RETURN(paths.local, store.ReadTrajectory(paths.name, v1::TRAJECTORY_FRAME_LOCAL));
  }
  ASSIGN_OR_RETURN(Accuracy accuracy, ComputeAccuracy(robots, 0, Alignment::kSe3));
  RETURN_IF_ERROR(CheckTruth(truth, robots, accuracy.fused));
  return std::move(accuracy.fused);
}

absl::Status Draw(const ServedMap& map, const std::string& own, const FusedAccuracy& accuracy,
                  const std::vector<RobotPaths>& robots, const RenderArguments& arguments) {
  const MapPicture picture = ComposePicture(map, own, accuracy, DrivenOf(robots));
  if (IsSvg(arguments.out)) {
    ASSIGN_OR_RETURN(const std::string svg,
                     RenderMapSvg(picture, SvgStyle::kAlone, arguments.picture));
    return WriteAtomically(arguments.out, svg);
  }
  ASSIGN_OR_RETURN(const cv::Mat image, RenderMap(picture, arguments.picture));
  return WriteImage(image, arguments.out);
}

// Says what a picture of the global map has not got.
void SayElsewhere(const ServedMap& map, const RenderArguments& arguments) {
  if (map.elsewhere.islands == 0) return;
  Say(absl::StrCat(
      arguments.out, " is without ", Describe(map.elsewhere),
      ", which nothing connects with the global map; map_viewer shows them beside it\n"));
}

// A robot that lies elsewhere is none of the picture of now.
absl::StatusOr<std::string> ChooseOwnOf(const ServedMap& map, const RenderArguments& arguments) {
  std::vector<std::string> agents = ListAgents(map);
  if (map.elsewhere.keyframes.contains(arguments.own) &&
      !absl::c_linear_search(agents, arguments.own)) {
    return absl::FailedPreconditionError(
        absl::StrCat("--own ", arguments.own,
                     ": nothing connects this robot with the global map yet, which is of ",
                     absl::StrJoin(agents, ", "), "; map_viewer shows its map, too"));
  }
  return ChooseOwn(arguments.own, agents);
}

absl::Status Render(const RenderArguments& arguments) {
  RETURN_IF_ERROR(CheckNameSegment("--mission", arguments.mission));
  RETURN_IF_ERROR(CheckOut(arguments.out));
  ASSIGN_OR_RETURN(const std::shared_ptr<grpc::Channel> channel,
                   ConnectToStoreOf(arguments.mission, arguments.server, arguments.security));
  StoreReader store(channel, arguments.mission);
  const ProgressTicker ticker("reads and draws mission " + arguments.mission);
  // Without keyframes a mission has no map to wait for.
  ASSIGN_OR_RETURN(const v1::GetStatisticsResponse statistics, store.Statistics());
  ServedMap map;
  if (statistics.mission().islands_size() > 0) {
    ASSIGN_OR_RETURN(map, store.ReadGlobalMap());
  }
  if (map.keyframes.empty()) {
    return absl::NotFoundError("mission " + arguments.mission + " has no keyframes yet");
  }
  ASSIGN_OR_RETURN(const std::string own, ChooseOwnOf(map, arguments));
  ASSIGN_OR_RETURN(const std::vector<RobotPaths> paths, ReadPaths(store, ListAgents(map)));
  ASSIGN_OR_RETURN(const FusedAccuracy accuracy, AlignTruth(store, paths, arguments.truth));
  RETURN_IF_ERROR(Draw(map, own, accuracy, paths, arguments));
  SayElsewhere(map, arguments);
  PrintResult(
      absl::StrCat(arguments.out, ": ", map.keyframes.size(), " keyframes in the global map\n"),
      {{"mission", arguments.mission},
       {"own", own},
       {"files", nlohmann::ordered_json::array({arguments.out})},
       {"keyframes", map.keyframes.size()},
       {"keyframes_elsewhere", map.elsewhere.keyframes}});
  return absl::OkStatus();
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
  render->add_option("--width", arguments->picture.width_px, "Pixels")
      ->check(CLI::Range(200, 10'000))
      ->capture_default_str();
  render->add_option("--out", arguments->out, "The picture to write: FILE.svg or FILE.png")
      ->capture_default_str();
  AddTlsFlags(*render, arguments->security);
  AddClientFlags(*render, arguments->security);
  render->callback([arguments, &chosen] { chosen = [arguments] { return Render(*arguments); }; });
}

}  // namespace corbslam::services
