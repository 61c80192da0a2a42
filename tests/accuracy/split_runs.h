// Reads what runs of `corbslam run` say of their accuracy.
#ifndef CORBSLAM_TESTS_ACCURACY_SPLIT_RUNS_H_
#define CORBSLAM_TESTS_ACCURACY_SPLIT_RUNS_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace corbslam::tests {

struct RobotOfRun {
  std::string name;
  int lost_frames = 0;
  // Errors after one rigid alignment each; none where they can't be told: several local maps have
  // no common local frame, and what is not connected has no global one.
  std::optional<double> local_ate_m;
  std::optional<double> global_ate_m;
};

struct SplitRun {
  std::string folder;  // "3" for the third one.
  std::string version;
  std::string command;
  int islands = 0;
  int keyframes = 0;
  // Errors of all robots under one alignment; none unless all hang together.
  std::optional<double> ate_m;
  std::optional<double> ate_from_frame_m;
  std::optional<double> ate_without_scale_m;
  std::vector<RobotOfRun> robots;
};

// Reads FOLDER/NAME/*/report.json, in the order of the runs' names; returns none where there are
// none. DATA_LOSS names the report that can't be understood.
absl::StatusOr<std::vector<SplitRun>> ReadRuns(const std::string& folder, const std::string& name);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_ACCURACY_SPLIT_RUNS_H_
