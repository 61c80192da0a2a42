#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "services/tool/commands/commands.h"
#include "services/tool/evaluation/evaluation_input.h"
#include "services/tool/output/result.h"
#include "slam/evaluation/trajectory_error.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::services {
namespace {

// A sequence recorded at one frame a second still finds its own truth within this gap.
constexpr double kLargestGap_s = 1;

struct EvalArguments {
  EvaluationFiles files;
  std::string truth_frame = "own";
  std::string alignment = "se3";
  double max_gap_s = static_cast<double>(kMaxAssociationGap_ns) * 1e-9;
  std::string json;
};

absl::StatusOr<int64_t> MaxGap_ns(double max_gap_s) {
  // The comparison is written so that NaN is refused.
  if (!(max_gap_s >= 1e-9 && max_gap_s <= kLargestGap_s)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--max-gap is ", max_gap_s, " s, must be from 1e-9 (equal times only) to ",
                     kLargestGap_s, " s: further apart a true pose says nothing of an estimate"));
  }
  return std::llround(max_gap_s * 1e9);
}

absl::StatusOr<nlohmann::ordered_json> Measure(const std::string& name,
                                               const std::vector<PosePair>& pairs,
                                               const std::optional<RelativeError>& relative,
                                               Alignment alignment) {
  const absl::StatusOr<AbsoluteError> error = ComputeAbsoluteError(pairs, alignment);
  if (!error.ok()) {
    return absl::Status(error.status().code(), absl::StrCat(name, ": ", error.status().message()));
  }
  nlohmann::ordered_json json = {{"name", name},
                                 {"poses", error->poses},
                                 {"ate_m", error->rmse_m},
                                 {"mean_m", error->mean_m},
                                 {"median_m", error->median_m},
                                 {"max_m", error->max_m},
                                 {"scale", error->truth_from_estimate.scale},
                                 {"t_rel_percent", nullptr},
                                 {"r_rel_deg_per_100m", nullptr}};
  if (relative.has_value()) {
    json["t_rel_percent"] = relative->translation_percent;
    json["r_rel_deg_per_100m"] = relative->rotation_deg_per_100m;
  }
  return json;
}

void PrintRow(const nlohmann::ordered_json& row) {
  const auto number = [&](const char* key) {
    return row[key].is_null() ? std::string("-") : absl::StrFormat("%.4f", row[key].get<double>());
  };
  std::fputs(absl::StrFormat("%-32s %6d %9s %9s %9s %9s %9s %9s\n", row["name"].get<std::string>(),
                             row["poses"].get<size_t>(), number("ate_m"), number("median_m"),
                             number("max_m"), number("scale"), number("t_rel_percent"),
                             number("r_rel_deg_per_100m"))
                 .c_str(),
             stdout);
}

void SayUnpaired(const std::string& name, size_t poses, size_t pairs, double max_gap_s) {
  if (pairs == poses) return;
  std::fprintf(stderr, "%s: %zu of %zu poses have no true pose within %g s\n", name.c_str(),
               poses - pairs, poses, max_gap_s);
}

// Says so where the estimates fit the truth at another size only: a truth in millimetres, say, or
// a baseline that is wrong. Under a rigid alignment such errors look like a bad map's.
void SayOtherSize(const std::vector<PosePair>& pairs, Alignment alignment) {
  constexpr double kOtherSize = 1.5;
  const auto rigid = ComputeAbsoluteError(pairs, Alignment::kSe3);
  const auto similar = ComputeAbsoluteError(pairs, Alignment::kSim3);
  if (alignment == Alignment::kSim3 || !rigid.ok() || !similar.ok()) return;
  const double scale = similar->truth_from_estimate.scale;
  if (!(scale > kOtherSize || scale < 1 / kOtherSize)) return;
  if (!(similar->rmse_m < 0.5 * rigid->rmse_m)) return;
  std::fprintf(stderr,
               "the truth is %.4g times as large as the estimates: with that scale the ATE is %.4g "
               "m; are both in metres?\n",
               scale, similar->rmse_m);
}

// Returns the error along one path through all estimates, where these have one truth; else the mean
// over the segments of each.
std::optional<RelativeError> FusedRelative(const EvaluationInput& input,
                                           const std::vector<RelativeError>& of_each,
                                           int64_t max_gap_ns) {
  if (input.truths.size() > 1) return MeanOverSegments(of_each);
  const Trajectory& truth = input.truths.front();
  return ComputeRelativeError(AssociateByTime(MergeByTime(input.estimates), truth, max_gap_ns),
                              truth);
}

absl::Status Eval(const EvalArguments& arguments) {
  ASSIGN_OR_RETURN(const int64_t max_gap_ns, MaxGap_ns(arguments.max_gap_s));
  ASSIGN_OR_RETURN(const EvaluationInput input, ReadEvaluationInput(arguments.files));
  for (const std::string& note : input.notes) std::fprintf(stderr, "%s\n", note.c_str());
  const Alignment alignment = arguments.alignment == "sim3" ? Alignment::kSim3 : Alignment::kSe3;
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  std::vector<PosePair> all;
  std::vector<RelativeError> relative;
  for (size_t i = 0; i < input.estimates.size(); ++i) {
    const std::string& name = arguments.files.estimates[i];
    const Trajectory& truth = input.TruthOf(i);
    const auto pairs = AssociateByTime(input.estimates[i], truth, max_gap_ns);
    SayUnpaired(name, input.estimates[i].size(), pairs.size(), arguments.max_gap_s);
    all.insert(all.end(), pairs.begin(), pairs.end());
    const std::optional<RelativeError> own = ComputeRelativeError(pairs, truth);
    if (own.has_value()) relative.push_back(*own);
    ASSIGN_OR_RETURN(rows.emplace_back(), Measure(name, pairs, own, alignment));
  }
  if (input.is_one_frame) SayOtherSize(all, alignment);
  if (input.estimates.size() > 1 && input.is_one_frame) {
    const std::optional<RelativeError> fused = FusedRelative(input, relative, max_gap_ns);
    ASSIGN_OR_RETURN(rows.emplace_back(), Measure("fused", all, fused, alignment));
  } else if (input.estimates.size() > 1) {
    std::fputs("no fused error: --truth-frame shared says that the truths are in one frame\n",
               stderr);
  }
  if (WantsJson()) {
    PrintResult("", rows);
    return absl::OkStatus();
  }
  std::printf("%-32s %6s %9s %9s %9s %9s %9s %9s\n", "trajectory", "poses", "ATE, m", "median",
              "max", "scale", "t_rel, %", "deg/100m");
  for (const auto& row : rows) PrintRow(row);
  if (arguments.json.empty()) return absl::OkStatus();
  return WriteLines({rows.dump(2)}, arguments.json);
}

}  // namespace

void AddEvalCommand(CLI::App& app, Command& chosen) {
  auto arguments = std::make_shared<EvalArguments>();
  EvaluationFiles& files = arguments->files;
  CLI::App* eval = app.add_subcommand(
      "eval", "Errors of trajectories against the truth, each and all under one alignment");
  eval->add_option("--truth", files.truths,
                   "kitti:DIR, tum:DIR, euroc:DIR or sim:WORLD; or a file in TUM's, EuRoC's or "
                   "KITTI's form, its times in FILE.times or --truth-times. Of several sequences "
                   "again, for each trajectory in their order")
      ->required()
      ->allow_extra_args(false);
  eval->add_option("--truth-frame", arguments->truth_frame,
                   "Of several --truth: own (each has a frame of its own), or shared (one frame, "
                   "as of recordings of one room: all are aligned at once)")
      ->check(CLI::IsMember({"own", "shared"}))
      ->capture_default_str();
  eval->add_option("--truth-times", files.truth_times, "The times.txt of a KITTI file");
  eval->add_option("estimates", files.estimates,
                   "Trajectories in any form that mission export writes")
      ->required();
  eval->add_option("--poses-of", files.poses_of,
                   "What the estimates are of, where the files don't say it: camera (as recorded, "
                   "the left one), rectified (camera) or body")
      ->check(CLI::IsMember({"camera", "rectified", "body"}));
  eval->add_option("--align", arguments->alignment, "se3, or sim3 for maps without scale")
      ->check(CLI::IsMember({"se3", "sim3"}))
      ->capture_default_str();
  eval->add_option("--from-frame", files.from_frame,
                   "Only frames of the sequence from this one on, aligned on those")
      ->check(CLI::Range(0, 1'000'000'000));
  eval->add_option("--max-gap", arguments->max_gap_s,
                   "Seconds between estimate and truth, at most; up to 1")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  eval->add_option("--json", arguments->json,
                   "File to write the table to as JSON, too; - prints JSON instead");
  eval->callback([arguments, &chosen] {
    arguments->files.is_truth_shared = arguments->truth_frame == "shared";
    chosen = [arguments] { return Eval(*arguments); };
  });
}

}  // namespace corbslam::services
