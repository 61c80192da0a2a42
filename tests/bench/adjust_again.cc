// Global adjustments that fusion workers were asked for (fusion_worker --keep-adjustments), done
// again: what they cost, and how far the map is from the truth before and after. Prints a table and
// writes JSON.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "fusion_worker/local_fusion_worker.h"
#include "services/observe/adjustment_files/adjustment_file.h"
#include "services/simulated_source/simulated_source.h"
#include "services/tool/evaluation/accuracy.h"
#include "slam/evaluation/trajectory_error.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::tests {

using client_agent::ParseSourceSpec;
using client_agent::SourceSpec;
using fusion_worker::MakeLocalFusionWorker;
using services::GroundTruth;
using services::ReadAdjustment;
using services::ReadGroundTruth;

namespace {

using Json = nlohmann::ordered_json;

struct Flags {
  std::vector<std::string> files;
  std::string source;
  int max_iterations = 0;
  int threads = 2;
  std::string json;
};

// Errors of keyframes, each under an alignment of its own.
struct MapError {
  size_t keyframes = 0;
  double rigid_m = 0;
  double without_scale_m = 0;
  double scale = 1;  // Factor by which the map's lengths are to be multiplied.
};

struct Row {
  AdjustBundleResult result;
  // Errors of all keyframes (""), and of each local map.
  std::map<std::string, MapError> before;
  std::map<std::string, MapError> after;
};

absl::StatusOr<MapError> Measure(Trajectory estimate, const Trajectory& truth) {
  SortByTime(estimate);
  const std::vector<PosePair> pairs = AssociateByTime(estimate, truth);
  ASSIGN_OR_RETURN(const AbsoluteError rigid, ComputeAbsoluteError(pairs, Alignment::kSe3));
  ASSIGN_OR_RETURN(const AbsoluteError similar, ComputeAbsoluteError(pairs, Alignment::kSim3));
  return MapError{pairs.size(), rigid.rmse_m, similar.rmse_m, similar.truth_from_estimate.scale};
}

absl::StatusOr<std::map<std::string, MapError>> MeasureAll(const Map& map,
                                                           const Trajectory& truth) {
  std::map<std::string, Trajectory> parts;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const StampedPose pose{keyframe.payload->timestamp_ns, keyframe.camera_from_map.Inverse()};
    parts[""].push_back(pose);
    parts[ToString(id.local_map)].push_back(pose);
  }
  std::map<std::string, MapError> errors;
  for (const auto& [name, part] : parts) {
    absl::StatusOr<MapError> error = Measure(part, truth);
    if (error.ok()) errors.emplace(name, *error);
  }
  if (!errors.contains("")) return absl::NotFoundError("no three keyframes have a true pose");
  return errors;
}

absl::StatusOr<Row> AdjustAgain(const std::string& file, const Trajectory& truth,
                                const Flags& flags, FusionWorker& worker) {
  ASSIGN_OR_RETURN(AdjustBundleRequest request, ReadAdjustment(file));
  request.threads = flags.threads;
  if (flags.max_iterations > 0) request.max_iterations = flags.max_iterations;
  Row row;
  ASSIGN_OR_RETURN(row.before, MeasureAll(request.view, truth));
  ASSIGN_OR_RETURN(row.result, worker.AdjustBundle(request, nullptr));
  for (const KeyframePose& pose : row.result.poses) {
    request.view.SetPose(pose.id, pose.camera_from_map.ToRigid());
  }
  ASSIGN_OR_RETURN(row.after, MeasureAll(request.view, truth));
  return row;
}

void Print(const std::string& file, const Row& row) {
  for (const auto& [name, after] : row.after) {
    const MapError& before = row.before.at(name);
    const bool whole = name.empty();
    absl::PrintF("| %s | %4d | %.4f, %.4f (%.5f) | %.4f, %.4f (%.5f) |", whole ? file : "  " + name,
                 after.keyframes, before.rigid_m, before.without_scale_m, before.scale,
                 after.rigid_m, after.without_scale_m, after.scale);
    if (whole) {
      absl::PrintF(" %d | %.1f | %.0f |", row.result.iterations, row.result.final_cost,
                   1000 * row.result.seconds);
    }
    absl::PrintF("\n");
  }
  std::fflush(stdout);
}

Json ToJson(const std::map<std::string, MapError>& errors) {
  Json json;
  for (const auto& [name, error] : errors) {
    json[name.empty() ? "all" : name] = {{"keyframes", error.keyframes},
                                         {"rigid_m", error.rigid_m},
                                         {"without_scale_m", error.without_scale_m},
                                         {"scale", error.scale}};
  }
  return json;
}

Json ToJson(const std::string& file, const Row& row) {
  return {{"file", file},
          {"before", ToJson(row.before)},
          {"after", ToJson(row.after)},
          {"iterations", row.result.iterations},
          {"initial_cost", row.result.initial_cost},
          {"final_cost", row.result.final_cost},
          {"ms", 1000 * row.result.seconds}};
}

absl::Status Run(const Flags& flags) {
  ASSIGN_OR_RETURN(const SourceSpec source, ParseSourceSpec(flags.source));
  ASSIGN_OR_RETURN(const std::optional<GroundTruth> truth, ReadGroundTruth(source));
  if (!truth.has_value()) {
    return absl::NotFoundError(absl::StrCat(flags.source, " has no ground truth"));
  }
  const std::unique_ptr<FusionWorker> worker = MakeLocalFusionWorker({});
  std::printf(
      "| adjustment | keyframes | before, m: rigid, without scale (scale) | after | iterations | "
      "cost | ms |\n| --- | --- | --- | --- | --- | --- | --- |\n");
  Json rows = Json::array();
  for (const std::string& file : flags.files) {
    ASSIGN_OR_RETURN(const Row row, AdjustAgain(file, truth->trajectory, flags, *worker));
    Print(file, row);
    rows.push_back(ToJson(file, row));
  }
  if (flags.json.empty()) return absl::OkStatus();
  return WriteLines({Json{{"source", flags.source}, {"rows", rows}}.dump(2)}, flags.json);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::RegisterSimulatedSources();
  corbslam::tests::Flags flags;
  CLI::App app("Global adjustments done again", "adjust_again");
  app.add_option("files", flags.files, "What fusion_worker --keep-adjustments wrote")->required();
  app.add_option("--source", flags.source, "Where the truth is: kitti:DIR, tum:DIR, sim:...")
      ->required();
  app.add_option("--max-iterations", flags.max_iterations, "0: as many as were asked for")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  app.add_option("--threads", flags.threads, "Of the solver")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  app.add_option("--json", flags.json, "File for the rows");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = corbslam::tests::Run(flags);
  if (status.ok()) return 0;
  std::fprintf(stderr, "adjust_again: %s\n", status.ToString().c_str());
  return 1;
}
