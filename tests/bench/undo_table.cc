// What is left of a wrong overlap after it was taken back. Recorded robots are fused in one
// process: honestly; then again with a worker that lies, at the beginning, in the middle
// or near the end; then the lies are taken back (MapStore::RetractOverlap), and the global layer is
// not derived again. Prints a table and writes JSON. Exit status 1: the bar is missed.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "tests/bench/lying_worker.h"
#include "tests/bench/replayed_mission.h"

namespace corbslam::tests {

using map_store::MapStore;
using map_store::OverlapFilter;
using map_store::OverlapInfo;
using map_store::Page;

namespace {

using Json = nlohmann::ordered_json;

// Largest error, as a share of that of the map that never had the lie.
constexpr double kMaxRatio = 1.02;

struct Flags {
  std::string source;
  size_t robots = 2;
  std::vector<int> percents = {0, 50, 90};
  int seeds = 3;
  int lies = 1;
  double shift_m = 5;
  std::string json;
};

struct Row {
  int percent = 0;  // Share of the honest mission's verified places before the lie.
  int seed = 0;
  size_t believed = 0;  // Number of lies that were believed.
  FusedMapError never;
  FusedMapError with;
  FusedMapError after;

  double Ratio() const { return after.ate_m / never.ate_m; }
  bool IsMet() const {
    return after.islands == never.islands && after.frames == never.frames && Ratio() <= kMaxRatio;
  }
};

// Returns the lies that were believed.
absl::StatusOr<std::vector<uint64_t>> FindLies(const MapStore& store, const LyingWorker& worker) {
  OverlapFilter accepted;
  accepted.accepted = true;
  ASSIGN_OR_RETURN(const Page<OverlapInfo> page,
                   store.ListOverlaps(ReplayedMission::name(), accepted, {}));
  std::vector<uint64_t> lies;
  for (const OverlapInfo& info : page.items) {
    if (worker.IsLie(info.overlap)) lies.push_back(info.id);
  }
  if (lies.empty()) return absl::NotFoundError("no lie was believed");
  return lies;
}

absl::StatusOr<Row> TellAndTakeBack(const RecordedMission& recorded, const LieOptions& lie) {
  LyingWorker worker(lie);
  ReplayedMission mission(recorded, {}, &worker);
  RETURN_IF_ERROR(mission.Stream());
  Row row;
  ASSIGN_OR_RETURN(row.with, mission.Error());
  ASSIGN_OR_RETURN(const std::vector<uint64_t> lies, FindLies(mission.store(), worker));
  row.believed = lies.size();
  for (const uint64_t id : lies) {
    RETURN_IF_ERROR(
        mission.store().RetractOverlap(ReplayedMission::name(), id, /*keep_apart=*/false).status());
    RETURN_IF_ERROR(mission.Fuse());
  }
  ASSIGN_OR_RETURN(row.after, mission.Error());
  return row;
}

void Print(const Row& row) {
  absl::PrintF("| %3d %% | %4d | %4d | %11.4f | %8.4f | %10.4f | %5.3f | %d, %d, %d | %s |\n",
               row.percent, row.seed, row.believed, row.never.ate_m, row.with.ate_m,
               row.after.ate_m, row.Ratio(), row.never.islands, row.with.islands, row.after.islands,
               row.IsMet() ? "met" : "MISSED");
  std::fflush(stdout);
}

Json ToJson(const FusedMapError& error) {
  return {{"ate_m", error.ate_m}, {"islands", error.islands}, {"frames", error.frames}};
}

Json ToJson(const Row& row) {
  return {{"percent", row.percent},     {"seed", row.seed},         {"lies", row.believed},
          {"never", ToJson(row.never)}, {"with", ToJson(row.with)}, {"after", ToJson(row.after)},
          {"ratio", row.Ratio()},       {"met", row.IsMet()}};
}

absl::StatusOr<bool> Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const RecordedMission recorded, RecordMission(flags.source, flags.robots));
  LyingWorker honest(std::nullopt);
  ReplayedMission never(recorded, {}, &honest);
  RETURN_IF_ERROR(never.Stream());
  ASSIGN_OR_RETURN(const FusedMapError error, never.Error());
  std::printf(
      "| lie at | seed | lies | never had it | with it  | taken back | ratio | islands | at most "
      "1.02 |\n"
      "| ------ | ---- | ---- | ----------- | -------- | ---------- | ----- | ------- | "
      "------------ |\n");
  Json rows = Json::array();
  bool all_met = true;
  for (const int percent : flags.percents) {
    for (int seed = 1; seed <= flags.seeds; ++seed) {
      LieOptions lie;
      lie.after = honest.verified() * percent / 100;
      lie.lies = flags.lies;
      lie.shift_m = flags.shift_m;
      lie.seed = static_cast<uint64_t>(seed);
      ASSIGN_OR_RETURN(Row row, TellAndTakeBack(recorded, lie));
      row.percent = percent;
      row.seed = seed;
      row.never = error;
      Print(row);
      rows.push_back(ToJson(row));
      all_met &= row.IsMet();
    }
  }
  if (flags.json.empty()) return all_met;
  RETURN_IF_ERROR(WriteLines({Json{{"source", flags.source}, {"rows", rows}}.dump(2)}, flags.json));
  return all_met;
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  corbslam::tests::Flags flags;
  CLI::App app("Taking back a wrong overlap", "undo_table");
  app.add_option("--source", flags.source, "What the robots share: kitti:DIR, tum:DIR, ...")
      ->required();
  app.add_option("--robots", flags.robots, "Among how many it is split")->capture_default_str();
  app.add_option("--at", flags.percents, "When the lie is told, percent of all verified places")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  app.add_option("--seeds", flags.seeds, "Lies at each time")->capture_default_str();
  app.add_option("--lies", flags.lies, "One, and those that stand by it")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--shift", flags.shift_m, "How far off the lie is, metres")->capture_default_str();
  app.add_option("--json", flags.json, "File for the rows");
  CLI11_PARSE(app, argc, argv);
  const absl::StatusOr<bool> all_met = corbslam::tests::Run(flags);
  if (all_met.ok()) return *all_met ? 0 : 1;
  std::fprintf(stderr, "undo_table: %s\n", all_met.status().ToString().c_str());
  return 2;
}
