#include <cstdio>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client_agent/source/frame_reader.h"
#include "services/corbslam/accuracy.h"
#include "services/corbslam/commands.h"
#include "slam/evaluation/trajectory_io.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

struct EvalArguments {
  std::string truth;
  std::string truth_times;
  std::vector<std::string> estimates;
  std::string alignment = "se3";
  std::optional<size_t> from_frame;
  double max_gap_s = static_cast<double>(kMaxAssociationGap_ns) * 1e-9;
  std::string json;
};

struct Truth {
  Trajectory trajectory;
  int64_t from_ns = std::numeric_limits<int64_t>::min();
};

absl::StatusOr<Truth> ReadRecordedTruth(const EvalArguments& arguments) {
  ASSIGN_OR_RETURN(const SourceSpec source, ParseSourceSpec(arguments.truth));
  ASSIGN_OR_RETURN(std::optional<Trajectory> trajectory, ReadGroundTruth(source));
  if (!trajectory.has_value()) {
    return absl::NotFoundError(absl::StrCat("no ground truth in ", source.directory));
  }
  Truth truth{*std::move(trajectory)};
  if (!arguments.from_frame.has_value()) return truth;
  ASSIGN_OR_RETURN(const std::unique_ptr<FrameReader> frames, OpenReader(source));
  if (*arguments.from_frame >= frames->frame_count()) {
    return absl::InvalidArgumentError(absl::StrCat("--from-frame ", *arguments.from_frame,
                                                   ": there are ", frames->frame_count()));
  }
  truth.from_ns = frames->timestamp_ns(*arguments.from_frame);
  return truth;
}

// A KITTI file when times are given, else TUM's form.
absl::StatusOr<Truth> ReadTruthFile(const EvalArguments& arguments) {
  Truth truth;
  if (!arguments.truth_times.empty()) {
    ASSIGN_OR_RETURN(truth.trajectory, ReadKittiTrajectory(arguments.truth, arguments.truth_times));
  } else {
    ASSIGN_OR_RETURN(truth.trajectory, ReadTumTrajectory(arguments.truth));
  }
  if (!arguments.from_frame.has_value()) return truth;
  if (*arguments.from_frame >= truth.trajectory.size()) {
    return absl::InvalidArgumentError(absl::StrCat("--from-frame ", *arguments.from_frame,
                                                   ": the truth has ", truth.trajectory.size()));
  }
  truth.from_ns = truth.trajectory[*arguments.from_frame].timestamp_ns;
  return truth;
}

absl::StatusOr<Truth> ReadTruth(const EvalArguments& arguments) {
  for (const char* layout : {"kitti:", "tum:", "euroc:", "sim:"}) {
    if (absl::StartsWith(arguments.truth, layout)) return ReadRecordedTruth(arguments);
  }
  return ReadTruthFile(arguments);
}

absl::StatusOr<nlohmann::ordered_json> Measure(const std::string& name,
                                               const std::vector<PosePair>& pairs,
                                               const std::vector<PosePair>& in_time,
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
  if (const auto relative = ComputeRelativeError(in_time); relative.has_value()) {
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

absl::Status Eval(const EvalArguments& arguments) {
  ASSIGN_OR_RETURN(const Truth truth, ReadTruth(arguments));
  const Alignment alignment = arguments.alignment == "sim3" ? Alignment::kSim3 : Alignment::kSe3;
  const auto max_gap_ns = static_cast<int64_t>(arguments.max_gap_s * 1e9);
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  std::vector<PosePair> all;
  std::vector<Trajectory> trajectories;
  for (const std::string& path : arguments.estimates) {
    ASSIGN_OR_RETURN(const Trajectory estimate, ReadTumTrajectory(path));
    trajectories.push_back(KeepFrom(estimate, truth.from_ns));
    const auto pairs = AssociateByTime(trajectories.back(), truth.trajectory, max_gap_ns);
    all.insert(all.end(), pairs.begin(), pairs.end());
    ASSIGN_OR_RETURN(rows.emplace_back(), Measure(path, pairs, pairs, alignment));
  }
  if (trajectories.size() > 1) {
    const auto merged = AssociateByTime(MergeByTime(trajectories), truth.trajectory, max_gap_ns);
    ASSIGN_OR_RETURN(rows.emplace_back(), Measure("fused", all, merged, alignment));
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
  CLI::App* eval = app.add_subcommand(
      "eval", "Errors of trajectories against the truth, each and all under one alignment");
  eval->add_option(
          "--truth", arguments->truth,
          "kitti:DIR, tum:DIR, euroc:DIR or sim:WORLD; or a file in TUM's form; or KITTI's "
          "with --truth-times")
      ->required();
  eval->add_option("--truth-times", arguments->truth_times, "The times.txt of a KITTI file");
  eval->add_option("estimates", arguments->estimates, "Trajectories in TUM's form")->required();
  eval->add_option("--align", arguments->alignment, "se3, or sim3 for maps without scale")
      ->check(CLI::IsMember({"se3", "sim3"}))
      ->capture_default_str();
  eval->add_option("--from-frame", arguments->from_frame,
                   "Only frames of the sequence from this one on, aligned on those");
  eval->add_option("--max-gap", arguments->max_gap_s, "Seconds between estimate and truth, at most")
      ->capture_default_str();
  eval->add_option("--json", arguments->json, "Write the table as JSON, too");
  eval->callback([arguments, &chosen] { chosen = [arguments] { return Eval(*arguments); }; });
}

}  // namespace corbslam
