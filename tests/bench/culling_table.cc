// What culling keyframes from the global layer costs and saves: recorded robots fused in one
// process with and without --cull-share and --cull-target of map_store. Prints a table and writes
// JSON.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "fusion_worker/local_fusion_worker.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "tests/bench/replayed_mission.h"
#include "tests/bench/timed_worker.h"

namespace corbslam::tests {

using fusion_worker::MakeLocalFusionWorker;
using map_store::MapStoreOptions;
using map_store::MissionStatistics;

namespace {

using Json = nlohmann::ordered_json;

struct Flags {
  std::string source;
  size_t robots = 2;
  std::vector<double> shares = {0.95, 0.9, 0.8, 0.7};
  std::vector<size_t> targets = {40};
  std::string json;
};

struct Row {
  double share = 0;
  size_t target = 0;
  size_t stored = 0;  // Number of keyframes; the robots keep them all.
  FusedMapError error;
  TimedWorker::Adjustment last;  // The last adjustment, which was given the culled map.
  size_t adjustments = 0;
  double all_ms = 0;
};

absl::StatusOr<Row> Measure(const RecordedMission& recorded, double share, size_t target) {
  TimedWorker worker(MakeLocalFusionWorker(), 1);
  MapStoreOptions options;
  options.cull_share = share;
  options.cull_target = target;
  ReplayedMission mission(recorded, options, &worker);
  RETURN_IF_ERROR(mission.Stream());
  Row row;
  row.share = share;
  row.target = target;
  ASSIGN_OR_RETURN(row.error, mission.Error());
  ASSIGN_OR_RETURN(const MissionStatistics statistics,
                   mission.store().GetStatistics(ReplayedMission::name()));
  row.stored = statistics.keyframes;
  if (worker.adjustments().empty()) {
    return absl::InternalError(absl::StrCat(row.error.islands, " islands, none was adjusted"));
  }
  row.last = worker.adjustments().back();
  row.adjustments = worker.adjustments().size();
  for (const TimedWorker::Adjustment& adjustment : worker.adjustments()) {
    row.all_ms += adjustment.ms;
  }
  return row;
}

void Print(const Row& row) {
  absl::PrintF("| %5g | %6d | %d | %7.4f | %5d of %5d | %6d | %12d | %9.1f | %2d in %7.1f ms |\n",
               row.share, row.target, row.error.islands, row.error.ate_m, row.last.keyframes,
               row.stored, row.last.points, row.last.observations, row.last.ms, row.adjustments,
               row.all_ms);
  std::fflush(stdout);
}

Json ToJson(const Row& row) {
  return {{"cull_share", row.share},           {"cull_target", row.target},
          {"islands", row.error.islands},      {"ate_m", row.error.ate_m},
          {"stored_keyframes", row.stored},    {"keyframes", row.last.keyframes},
          {"map_points", row.last.points},     {"observations", row.last.observations},
          {"last_adjustment_ms", row.last.ms}, {"adjustments", row.adjustments},
          {"all_adjustments_ms", row.all_ms}};
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const RecordedMission recorded, RecordMission(flags.source, flags.robots));
  std::printf(
      "| share | target | islands | ATE, m | keyframes | points | observations | last BA, ms | all "
      "BA |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  Json rows = Json::array();
  const auto measure = [&](double share, size_t target) -> absl::Status {
    ASSIGN_OR_RETURN(const Row row, Measure(recorded, share, target));
    Print(row);
    rows.push_back(ToJson(row));
    return absl::OkStatus();
  };
  RETURN_IF_ERROR(measure(0, 0));
  for (const double share : flags.shares) RETURN_IF_ERROR(measure(share, 0));
  for (const size_t target : flags.targets) RETURN_IF_ERROR(measure(0, target));
  if (flags.json.empty()) return absl::OkStatus();
  return WriteLines({Json{{"source", flags.source}, {"rows", rows}}.dump(2)}, flags.json);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  corbslam::tests::Flags flags;
  CLI::App app("Culling redundant keyframes", "culling_table");
  app.add_option("--source", flags.source, "What the robots share: kitti:DIR, tum:DIR, ...")
      ->required();
  app.add_option("--robots", flags.robots, "Among how many it is split")->capture_default_str();
  app.add_option("--shares", flags.shares, "Of --cull-share")->capture_default_str();
  app.add_option("--targets", flags.targets, "Of --cull-target")->capture_default_str();
  app.add_option("--json", flags.json, "File for the rows");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "culling_table: %s\n", status.ToString().c_str());
  return 1;
}
