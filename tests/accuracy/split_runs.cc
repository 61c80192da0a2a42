#include "tests/accuracy/split_runs.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::tests {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::optional<double> Optional(const Json& value) {
  return value.is_null() ? std::nullopt : std::optional(value.get<double>());
}

RobotOfRun ReadRobot(const Json& json) {
  RobotOfRun robot;
  robot.name = json.at("name");
  robot.lost_frames = json.at("lost");
  // With several local maps `ate_m` is the global trajectory's.
  if (json.at("local_maps") == 1) robot.local_ate_m = Optional(json.at("ate_m"));
  robot.global_ate_m = Optional(json.at("ate_global_m"));
  return robot;
}

SplitRun ReadReport(const Json& json) {
  SplitRun run;
  run.version = json.at("version");
  run.command = json.at("command");
  const Json& fused = json.at("fused");
  run.islands = fused.at("islands");
  run.keyframes = fused.at("keyframes");
  run.ate_m = Optional(fused.at("ate_m"));
  run.ate_from_frame_m = Optional(fused.at("ate_from_frame_m"));
  // Older reports don't have it.
  if (fused.contains("ate_without_scale_m")) {
    run.ate_without_scale_m = Optional(fused.at("ate_without_scale_m"));
  }
  for (const Json& robot : json.at("robots")) run.robots.push_back(ReadRobot(robot));
  return run;
}

absl::StatusOr<SplitRun> ReadRun(const fs::path& report) {
  std::ifstream file(report);
  try {
    SplitRun run = ReadReport(Json::parse(file));
    run.folder = report.parent_path().filename();
    return run;
  } catch (const Json::exception& error) {
    return absl::DataLossError(absl::StrCat(report.string(), ": ", error.what()));
  }
}

}  // namespace

absl::StatusOr<std::vector<SplitRun>> ReadRuns(const std::string& folder, const std::string& name) {
  std::vector<SplitRun> runs;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(folder) / name, error)) {
    const fs::path report = entry.path() / "report.json";
    if (!fs::exists(report, error)) continue;
    ASSIGN_OR_RETURN(SplitRun run, ReadRun(report));
    runs.push_back(std::move(run));
  }
  std::sort(runs.begin(), runs.end(), [](const SplitRun& a, const SplitRun& b) {
    return std::pair(a.folder.size(), a.folder) < std::pair(b.folder.size(), b.folder);
  });
  return runs;
}

}  // namespace corbslam::tests
