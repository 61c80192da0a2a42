// Judges what several robots map together against what one maps alone, and against its bars.
#ifndef CORBSLAM_TESTS_ACCURACY_SPLIT_VERDICT_H_
#define CORBSLAM_TESTS_ACCURACY_SPLIT_VERDICT_H_

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/accuracy/split_runs.h"

namespace corbslam::tests {

// One robot of a split, over the runs in which both of its errors are known.
struct RobotVerdict {
  std::string name;
  int runs = 0;
  int worse_runs = 0;  // Runs in which the global layer's error is above the local one's.
  std::optional<double> local_ate_m;  // Medians.
  std::optional<double> global_ate_m;

  // True if the global layer's median is at most the local one's.
  bool IsMet() const { return runs > 0 && *global_ate_m <= *local_ate_m; }
};

struct SplitVerdict {
  // The fused median is at most this much of the single robot's.
  static constexpr double kMaxRatio = 1.05;

  std::string name;
  std::string reference;
  int wanted_runs = 0;
  std::vector<SplitRun> runs;
  std::vector<SplitRun> reference_runs;
  int most_islands = 0;
  std::optional<double> ate_m;  // Medians; none unless every run has one.
  std::optional<double> ate_from_frame_m;
  std::optional<double> ate_without_scale_m;
  std::optional<double> reference_ate_m;
  std::optional<double> reference_ate_from_frame_m;
  std::optional<double> reference_ate_without_scale_m;
  std::vector<RobotVerdict> robots;

  bool IsComplete() const;
  std::optional<double> Ratio() const;
  // True if every run has one island, and is accurate enough.
  bool IsMapMet() const;
  // True if that is so, and every robot's layers meet their bar.
  bool IsMet() const;
};

SplitVerdict Judge(const std::string& name, const std::string& reference,
                   std::vector<SplitRun> runs, std::vector<SplitRun> reference_runs,
                   int wanted_runs);

// Splits without runs are left out of the tables.
std::string ToMarkdown(const std::vector<SplitVerdict>& verdicts);
nlohmann::ordered_json ToJson(const std::vector<SplitVerdict>& verdicts);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_ACCURACY_SPLIT_VERDICT_H_
