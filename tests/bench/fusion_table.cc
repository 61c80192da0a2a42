// Table 2 of the CORB-SLAM paper (Li et al., section 4.2): how long a merge and the global bundle
// adjustment take, by the map's size. Two robots drive around a ring of landmarks, half of it each,
// and meet at both ends; what they upload is whole before fusion begins, so that the first merge
// joins all of it. No pictures: landmarks, descriptors, noise and drift are synthetic. Prints a
// table with the exponents of growth and writes JSON.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "fusion_worker/local_fusion_worker.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/test_agent.h"
#include "services/programs/default_vocabulary.h"
#include "services/server/process_usage.h"
#include "slam/fusing/testing/fused_maps.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"
#include "slam/verification/testing/synthetic_world.h"
#include "tests/bench/timed_worker.h"

namespace corbslam::tests {

using fusion_worker::MakeLocalFusionWorker;
using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;
using map_store::MissionStatistics;
using services::DefaultVocabularyPath;
using services::GetProcessUsage;

namespace {

using Json = nlohmann::ordered_json;
using testing::SyntheticMap;
using testing::TestAgent;

constexpr char kMission[] = "table";
// The street has a keyframe every 0.7 m that sees about 400 points, each of them six times; so has
// this ring.
constexpr double kSpacing_m = 0.7;
constexpr double kPointsPerMetre = 95;
constexpr size_t kTrackLength = 6;
// Number of keyframes at both ends together that both robots see.
constexpr int kShared = 40;

struct Flags {
  std::vector<int> keyframes = {136, 456, 1000, 3000};
  int threads = 2;
  std::string json;
};

struct Row {
  TimedWorker::Adjustment adjustment;  // The first adjustment after the merge.
  double merge_ms = 0;                 // Time from the verified overlap to the committed revision.
  double fuse_maps_ms = 0;             // The worker's part of it.
  size_t revisions = 0;
  double robots_ate_m = 0;
  double fused_ate_m = 0;
  double peak_rss_mb = 0;  // Peak of this program so far.
};

struct World {
  SyntheticMap alpha;
  SyntheticMap bravo;
};

World MakeWorld(int keyframes) {
  const int around = keyframes - kShared;
  const double radius_m = kSpacing_m * around / (2 * std::numbers::pi);
  const double step_degrees = 360.0 / around;
  const auto world =
      testing::MakeRingWorld(5, static_cast<int>(kPointsPerMetre * kSpacing_m * around), radius_m);
  const auto drive = [&](uint64_t id, int begin, int count, double yaw_rad) {
    testing::SyntheticMapOptions options;
    options.local_map = LocalMapId{id};
    options.seed = id;
    // The whole drive ends up a little off, however long it is.
    options.drift_yaw_rad = yaw_rad / count;
    options.max_observations = kTrackLength;
    return testing::MakeSyntheticMap(
        world, testing::PosesOnRing(begin * step_degrees, step_degrees, count, radius_m), options);
  };
  const int half = keyframes / 2;
  return {drive(0xa, 0, half, 0.02), drive(0xb, half - kShared / 2, keyframes - half, -0.02)};
}

double FusedAte(const MapStore& store, const World& world) {
  std::map<KeyframeId, Rigid3d> estimate;
  const auto truth = testing::JoinTruth(world.alpha, world.bravo);
  for (const auto& [id, pose] : truth) {
    const auto keyframe = store.GetKeyframe(kMission, id);
    if (keyframe.ok()) estimate[id] = keyframe->camera_from_island.ToRigid();
  }
  return testing::AteRmse_m(estimate, truth);
}

absl::StatusOr<Row> Measure(const Flags& flags, int keyframes,
                            const std::shared_ptr<const Vocabulary>& vocabulary) {
  const World world = MakeWorld(keyframes);
  TimedWorker worker(MakeLocalFusionWorker(), flags.threads);
  MapStoreOptions options;
  options.deterministic = true;
  MapStore store(options, vocabulary, std::make_unique<InMemoryJournal>(), &worker);
  for (const auto& [name, made] :
       {std::make_pair("alpha", &world.alpha), std::make_pair("bravo", &world.bravo)}) {
    TestAgent robot(store, kMission, name, *made);
    RETURN_IF_ERROR(robot.Stream());
    RETURN_IF_ERROR(robot.Close());
  }
  RETURN_IF_ERROR(store.RunFusionUntilIdle(kMission));
  ASSIGN_OR_RETURN(const MissionStatistics statistics, store.GetStatistics(kMission));
  if (statistics.islands != 1 || statistics.merge_ms.empty() || worker.adjustments().empty()) {
    return absl::InternalError(absl::StrCat(keyframes, " keyframes: ", statistics.islands,
                                            " islands after fusing, must be 1"));
  }
  Row row;
  row.adjustment = worker.adjustments().front();
  row.merge_ms = statistics.merge_ms.front();
  row.fuse_maps_ms = worker.fusings_ms().front();
  row.revisions = statistics.revision;
  row.robots_ate_m = std::max(
      testing::AteRmse_m(testing::PosesOf(world.alpha.map), world.alpha.true_camera_from_world),
      testing::AteRmse_m(testing::PosesOf(world.bravo.map), world.bravo.true_camera_from_world));
  row.fused_ate_m = FusedAte(store, world);
  row.peak_rss_mb = 1e-6 * static_cast<double>(GetProcessUsage().peak_rss_bytes);
  return row;
}

void PrintHead() {
  std::printf(
      "| keyframes | points  | observations | merge, ms | worker's part | BA, ms   | iterations | "
      "cost       | worse robot's ATE, m | fused, m | peak MB |\n"
      "| --------- | ------- | ------------ | --------- | ------------- | -------- | ---------- | "
      "---------- | -------------------- | -------- | ------- |\n");
}

void Print(const Row& row) {
  const TimedWorker::Adjustment& ba = row.adjustment;
  absl::PrintF(
      "| %9d | %7d | %12d | %9.1f | %13.1f | %8.1f | %10d | %10.4g | %20.3f | %8.3f | %7.0f |\n",
      ba.keyframes, ba.points, ba.observations, row.merge_ms, row.fuse_maps_ms, ba.ms,
      ba.iterations, ba.final_cost, row.robots_ate_m, row.fused_ate_m, row.peak_rss_mb);
  std::fflush(stdout);
}

// Returns the slope of log(y) over log(keyframes) by least squares.
double Exponent(const std::vector<Row>& rows, double (*value)(const Row&)) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const Row& row : rows) {
    const double x = std::log(static_cast<double>(row.adjustment.keyframes));
    const double y = std::log(value(row));
    n += 1;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

Json ToJson(const Row& row) {
  const TimedWorker::Adjustment& ba = row.adjustment;
  return {{"keyframes", ba.keyframes},
          {"map_points", ba.points},
          {"observations", ba.observations},
          {"merge_ms", row.merge_ms},
          {"fuse_maps_ms", row.fuse_maps_ms},
          {"global_adjustment_ms", ba.ms},
          {"iterations", ba.iterations},
          {"initial_cost", ba.initial_cost},
          {"final_cost", ba.final_cost},
          {"revisions", row.revisions},
          {"worse_robots_ate_m", row.robots_ate_m},
          {"fused_ate_m", row.fused_ate_m},
          {"peak_rss_mb", row.peak_rss_mb}};
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const std::shared_ptr<const Vocabulary> vocabulary,
                   Vocabulary::Load(DefaultVocabularyPath()));
  PrintHead();
  std::vector<Row> rows;
  Json json = Json::array();
  for (const int keyframes : flags.keyframes) {
    ASSIGN_OR_RETURN(const Row row, Measure(flags, keyframes, vocabulary));
    Print(row);
    rows.push_back(row);
    json.push_back(ToJson(row));
  }
  Json written = {{"threads", flags.threads}, {"rows", json}};
  if (rows.size() > 1) {
    const double merge = Exponent(rows, [](const Row& row) { return row.merge_ms; });
    const double adjustment = Exponent(rows, [](const Row& row) { return row.adjustment.ms; });
    absl::PrintF("\nmerge grows with keyframes^%.2f, global adjustment with keyframes^%.2f\n",
                 merge, adjustment);
    written["merge_exponent"] = merge;
    written["global_adjustment_exponent"] = adjustment;
  }
  if (flags.json.empty()) return absl::OkStatus();
  return WriteLines({written.dump(2)}, flags.json);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::tests::Flags flags;
  CLI::App app("Merge and global bundle adjustment by map size", "fusion_table");
  app.add_option("--keyframes", flags.keyframes, "Of both robots together")
      ->check(CLI::Range(100, 20000))
      ->capture_default_str();
  app.add_option("--threads", flags.threads, "Of global bundle adjustment")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--json", flags.json, "File for the rows");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "fusion_table: %s\n", status.ToString().c_str());
  return 1;
}
