// What an adjustment costs whoever watches the map with its points: recorded robots are fused in
// one process, and it is counted what a watcher is told of each revision of fusion. Prints a table
// and writes JSON; its counts do not depend on what else the machine does.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "fusion_worker/local_fusion_worker.h"
#include "map_store/store/map_store.h"
#include "services/map_store_service/map_changes_to_proto.h"
#include "services/simulated_source/simulated_source.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "tests/bench/replayed_mission.h"

namespace corbslam::tests {

using fusion_worker::MakeLocalFusionWorker;
using map_store::MapChanges;
using map_store::MapStoreOptions;
using map_store::MapWatcher;
using map_store::MissionStatistics;
using services::ToProto;

namespace {

using Json = nlohmann::ordered_json;

struct Flags {
  std::string source;
  size_t robots = 2;
  std::string json;
};

struct Told {
  size_t keyframes = 0;
  size_t points = 0;
  size_t bytes = 0;
};

// What the map had when fusion changed it, and what the watcher was told of that.
struct Row {
  uint64_t revision = 0;
  bool is_adjustment = false;
  size_t keyframes = 0;
  size_t points = 0;
  Told told;
};

class WatchedMission {
 public:
  explicit WatchedMission(const RecordedMission& recorded)
      : worker_(MakeLocalFusionWorker()), mission_(recorded, MapStoreOptions(), worker_.get()) {}

  absl::Status Stream() {
    return mission_.Stream([this](ReplayedMission::Step step) { return Note(step); });
  }
  const std::vector<Row>& rows() const { return rows_; }
  absl::StatusOr<FusedMapError> Error() const { return mission_.Error(); }

 private:
  absl::StatusOr<Told> Watch() {
    constexpr size_t kItemsInAPiece = 5000;
    Told told;
    while (true) {
      ASSIGN_OR_RETURN(const auto changes, mission_.store().NextChanges(ReplayedMission::name(),
                                                                        kItemsInAPiece, watcher_));
      if (!changes.has_value()) return told;
      for (const MapChanges::Island& island : changes->islands) {
        told.keyframes += island.keyframes.size();
        told.points += island.points.size() + island.removed_points.size();
      }
      for (const auto& response : ToProto(*changes)) told.bytes += response.ByteSizeLong();
    }
  }

  // What owners sent is taken before fusion, and is in no row.
  absl::Status Note(ReplayedMission::Step step) {
    ASSIGN_OR_RETURN(const Told told, Watch());
    if (step == ReplayedMission::Step::kSent) return absl::OkStatus();
    ASSIGN_OR_RETURN(const MissionStatistics now,
                     mission_.store().GetStatistics(ReplayedMission::name()));
    if (now.revision != revision_) {
      const bool is_adjustment = now.global_adjustments.size() > adjustments_;
      rows_.push_back({now.revision, is_adjustment, now.keyframes, now.map_points, told});
    }
    revision_ = now.revision;
    adjustments_ = now.global_adjustments.size();
    return absl::OkStatus();
  }

  const std::unique_ptr<FusionWorker> worker_;
  ReplayedMission mission_;
  MapWatcher watcher_{0, true};
  uint64_t revision_ = 0;
  size_t adjustments_ = 0;
  std::vector<Row> rows_;
};

Json ToJson(const Row& row) {
  return {{"revision", row.revision},
          {"adjusted", row.is_adjustment},
          {"keyframes", row.keyframes},
          {"points", row.points},
          {"told_keyframes", row.told.keyframes},
          {"told_points", row.told.points},
          {"bytes", row.told.bytes}};
}

void Print(const Row& row) {
  std::printf("| %8llu | %-8s | %9zu | %7zu | %14zu | %11zu | %9zu |\n",
              static_cast<unsigned long long>(row.revision), row.is_adjustment ? "yes" : "no",
              row.keyframes, row.points, row.told.keyframes, row.told.points, row.told.bytes);
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const RecordedMission recorded, RecordMission(flags.source, flags.robots));
  WatchedMission mission(recorded);
  RETURN_IF_ERROR(mission.Stream());
  std::printf(
      "| revision | adjusted | keyframes | points  | told keyframes | told points | bytes     |\n"
      "| -------- | -------- | --------- | ------- | -------------- | ----------- | --------- |\n");
  Json rows = Json::array();
  size_t bytes = 0;
  size_t adjusted_bytes = 0;
  for (const Row& row : mission.rows()) {
    Print(row);
    rows.push_back(ToJson(row));
    bytes += row.told.bytes;
    if (row.is_adjustment) adjusted_bytes += row.told.bytes;
  }
  ASSIGN_OR_RETURN(const FusedMapError error, mission.Error());
  std::printf("%zu bytes, %zu of them of adjustments; %zu islands, %.6f m\n", bytes, adjusted_bytes,
              error.islands, error.ate_m);
  if (flags.json.empty()) return absl::OkStatus();
  const Json all = {{"source", flags.source}, {"robots", flags.robots}, {"rows", rows}};
  return WriteLines({all.dump(2)}, flags.json);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  corbslam::tests::Flags flags;
  CLI::App app("What watchers are told of adjustments", "watched_adjustments");
  app.add_option("--source", flags.source, "What the robots share: kitti:DIR, tum:DIR, ...")
      ->required();
  app.add_option("--robots", flags.robots, "Among how many it is split")->capture_default_str();
  app.add_option("--json", flags.json, "File for the rows");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "watched_adjustments: %s\n", status.ToString().c_str());
  return 1;
}
