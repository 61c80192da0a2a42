#include "tests/accuracy/split_verdict.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace corbslam::tests {
namespace {

using Values = std::vector<double>;

std::optional<double> Median(Values values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

std::optional<double> MedianOf(const std::vector<SplitRun>& runs,
                               std::optional<double> SplitRun::*member) {
  Values values;
  for (const SplitRun& run : runs) {
    if (!(run.*member).has_value()) return std::nullopt;
    values.push_back(*(run.*member));
  }
  return Median(std::move(values));
}

RobotVerdict JudgeRobot(const std::vector<SplitRun>& runs, size_t index) {
  RobotVerdict verdict;
  Values local;
  Values global;
  for (const SplitRun& run : runs) {
    if (index >= run.robots.size()) continue;
    const RobotOfRun& robot = run.robots[index];
    verdict.name = robot.name;
    if (!robot.local_ate_m.has_value() || !robot.global_ate_m.has_value()) continue;
    ++verdict.runs;
    verdict.worse_runs += *robot.global_ate_m > *robot.local_ate_m;
    local.push_back(*robot.local_ate_m);
    global.push_back(*robot.global_ate_m);
  }
  verdict.local_ate_m = Median(std::move(local));
  verdict.global_ate_m = Median(std::move(global));
  return verdict;
}

}  // namespace

bool SplitVerdict::IsComplete() const {
  const auto wanted = static_cast<size_t>(wanted_runs);
  return runs.size() >= wanted && reference_runs.size() >= wanted;
}

std::optional<double> SplitVerdict::Ratio() const {
  if (!ate_m.has_value() || !reference_ate_m.has_value()) return std::nullopt;
  return *ate_m / *reference_ate_m;
}

bool SplitVerdict::IsMapMet() const {
  const std::optional<double> ratio = Ratio();
  return most_islands == 1 && ratio.has_value() && *ratio <= kMaxRatio;
}

bool SplitVerdict::IsMet() const {
  return IsMapMet() && std::all_of(robots.begin(), robots.end(),
                                   [](const RobotVerdict& robot) { return robot.IsMet(); });
}

SplitVerdict Judge(const std::string& name, const std::string& reference,
                   std::vector<SplitRun> runs, std::vector<SplitRun> reference_runs,
                   int wanted_runs) {
  SplitVerdict verdict;
  verdict.name = name;
  verdict.reference = reference;
  verdict.wanted_runs = wanted_runs;
  for (const SplitRun& run : runs) {
    verdict.most_islands = std::max(verdict.most_islands, run.islands);
  }
  verdict.ate_m = MedianOf(runs, &SplitRun::ate_m);
  verdict.ate_from_frame_m = MedianOf(runs, &SplitRun::ate_from_frame_m);
  verdict.ate_without_scale_m = MedianOf(runs, &SplitRun::ate_without_scale_m);
  verdict.reference_ate_m = MedianOf(reference_runs, &SplitRun::ate_m);
  verdict.reference_ate_from_frame_m = MedianOf(reference_runs, &SplitRun::ate_from_frame_m);
  verdict.reference_ate_without_scale_m = MedianOf(reference_runs, &SplitRun::ate_without_scale_m);
  const size_t robots = runs.empty() ? 0 : runs.front().robots.size();
  for (size_t i = 0; i < robots; ++i) verdict.robots.push_back(JudgeRobot(runs, i));
  verdict.runs = std::move(runs);
  verdict.reference_runs = std::move(reference_runs);
  return verdict;
}

}  // namespace corbslam::tests
