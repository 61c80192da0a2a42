#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tests/accuracy/split_verdict.h"

namespace corbslam::tests {
namespace {

using Json = nlohmann::ordered_json;

std::string Number(const std::optional<double>& value, int decimals) {
  return value.has_value() ? absl::StrFormat("%.*f", decimals, *value) : "–";
}

// Writes "0.2841 (0.2756 to 0.2878)".
std::string Spread(const std::optional<double>& median, const std::vector<SplitRun>& runs) {
  if (!median.has_value()) return "–";
  const auto [least, most] =
      std::minmax_element(runs.begin(), runs.end(),
                          [](const SplitRun& a, const SplitRun& b) { return *a.ate_m < *b.ate_m; });
  return absl::StrFormat("%.4f (%.4f to %.4f)", *median, *least->ate_m, *most->ate_m);
}

const char* Judgement(const SplitVerdict& verdict, bool is_met) {
  if (!verdict.IsComplete()) return "runs missing";
  return is_met ? "met" : "MISSED";
}

std::string MapRow(const SplitVerdict& verdict) {
  return absl::StrFormat(
      "| %s | %d, %d | %d | %s | %s | %s | %s; %s | %s; %s | %s |\n", verdict.name,
      verdict.runs.size(), verdict.reference_runs.size(), verdict.most_islands,
      Spread(verdict.ate_m, verdict.runs), Spread(verdict.reference_ate_m, verdict.reference_runs),
      Number(verdict.Ratio(), 3), Number(verdict.ate_from_frame_m, 4),
      Number(verdict.reference_ate_from_frame_m, 4), Number(verdict.ate_without_scale_m, 4),
      Number(verdict.reference_ate_without_scale_m, 4), Judgement(verdict, verdict.IsMapMet()));
}

std::string RobotRow(const SplitVerdict& verdict, const RobotVerdict& robot) {
  return absl::StrFormat("| %s | %s | %s | %s | %d of %d | %s |\n", verdict.name, robot.name,
                         Number(robot.local_ate_m, 4), Number(robot.global_ate_m, 4),
                         robot.worse_runs, robot.runs, Judgement(verdict, robot.IsMet()));
}

// Returns null where there is no value.
Json OrNull(const std::optional<double>& value) {
  return value.has_value() ? Json(*value) : Json(nullptr);
}

Json ToJson(const std::vector<SplitRun>& runs) {
  Json json = Json::array();
  for (const SplitRun& run : runs) {
    Json robots = Json::array();
    for (const RobotOfRun& robot : run.robots) {
      robots.push_back({{"name", robot.name},
                        {"lost", robot.lost_frames},
                        {"local_ate_m", OrNull(robot.local_ate_m)},
                        {"global_ate_m", OrNull(robot.global_ate_m)}});
    }
    json.push_back({{"run", run.folder},
                    {"version", run.version},
                    {"command", run.command},
                    {"islands", run.islands},
                    {"keyframes", run.keyframes},
                    {"ate_m", OrNull(run.ate_m)},
                    {"ate_from_frame_m", OrNull(run.ate_from_frame_m)},
                    {"ate_without_scale_m", OrNull(run.ate_without_scale_m)},
                    {"robots", robots}});
  }
  return json;
}

Json ToJson(const RobotVerdict& robot) {
  return {{"name", robot.name},
          {"local_ate_m", OrNull(robot.local_ate_m)},
          {"global_ate_m", OrNull(robot.global_ate_m)},
          {"met", robot.IsMet()},
          {"worse_runs", robot.worse_runs},
          {"runs", robot.runs}};
}

Json ToJson(const SplitVerdict& verdict) {
  Json robots = Json::array();
  for (const RobotVerdict& robot : verdict.robots) robots.push_back(ToJson(robot));
  return {{"name", verdict.name},
          {"reference", verdict.reference},
          {"complete", verdict.IsComplete()},
          {"map_met", verdict.IsMapMet()},
          {"met", verdict.IsMet()},
          {"islands", verdict.most_islands},
          {"ate_m", OrNull(verdict.ate_m)},
          {"reference_ate_m", OrNull(verdict.reference_ate_m)},
          {"ratio", OrNull(verdict.Ratio())},
          {"ate_from_frame_m", OrNull(verdict.ate_from_frame_m)},
          {"reference_ate_from_frame_m", OrNull(verdict.reference_ate_from_frame_m)},
          {"ate_without_scale_m", OrNull(verdict.ate_without_scale_m)},
          {"reference_ate_without_scale_m", OrNull(verdict.reference_ate_without_scale_m)},
          {"robots", robots},
          {"runs", ToJson(verdict.runs)},
          {"reference_runs", ToJson(verdict.reference_runs)}};
}

}  // namespace

std::string ToMarkdown(const std::vector<SplitVerdict>& verdicts) {
  std::string text = absl::StrFormat(
      "| split | runs, one robot's | most islands | fused ATE, m: median (min to max) | one "
      "robot's | ratio | from frame 15, m: fused; one robot's | without scale, m: fused; one "
      "robot's | at most %g of one robot's |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
      SplitVerdict::kMaxRatio);
  std::string robots =
      "\n| split | robot | local layer's ATE, m: median | global layer's | global above local | "
      "at most the local one's |\n| --- | --- | --- | --- | --- | --- |\n";
  for (const SplitVerdict& verdict : verdicts) {
    if (verdict.runs.empty()) continue;
    absl::StrAppend(&text, MapRow(verdict));
    for (const RobotVerdict& robot : verdict.robots) {
      absl::StrAppend(&robots, RobotRow(verdict, robot));
    }
  }
  return text + robots;
}

nlohmann::ordered_json ToJson(const std::vector<SplitVerdict>& verdicts) {
  Json json = {{"max_ratio", SplitVerdict::kMaxRatio}, {"splits", Json::array()}};
  for (const SplitVerdict& verdict : verdicts) json["splits"].push_back(ToJson(verdict));
  return json;
}

}  // namespace corbslam::tests
