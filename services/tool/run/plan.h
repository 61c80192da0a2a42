// Plans which robot plays which part of which sequence.
#ifndef CORBSLAM_SERVICES_TOOL_RUN_PLAN_H_
#define CORBSLAM_SERVICES_TOOL_RUN_PLAN_H_

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/source/source_spec.h"

namespace corbslam::services {

enum class SplitMode {
  kHalves,       // Each robot plays its part, as in the paper.
  kInterleaved,  // Robot k of n plays those frames of its part whose number leaves k mod n.
};

struct SplitOptions {
  size_t robots = 2;
  // Number of frames by which a part reaches beyond its share, on each side where there is another.
  size_t overlap = 20;
  SplitMode mode = SplitMode::kHalves;
};

// Splits frames [begin, end) into `robots` parts as TakePart does.
std::vector<client_agent::FrameSelection> SplitFrames(size_t begin, size_t end,
                                                      const SplitOptions& options);

struct RobotPlan {
  std::string name;
  client_agent::SourceSpec source;
};

struct PlanOptions {
  std::vector<client_agent::SourceSpec> sources;
  SplitOptions split;
  // True: the truths of recorded sequences are in one frame, as ?truth_frame= says of those of one
  // name; where a source says it, that stands.
  bool is_truth_shared = false;
  // Maps a robot's number (the first is 1) to a text as "gamma=0.8,noise=4,reverse".
  std::map<size_t, std::string> perturbations;
};

// Splits one source among the robots; of several sources each goes whole to a robot of its own.
// Returns INVALID_ARGUMENT for a split that leaves a robot fewer than 10 frames of its own share,
// for a source that is already one robot's part, and for a perturbation of a robot that is not
// there.
absl::StatusOr<std::vector<RobotPlan>> PlanRobots(const PlanOptions& options);

// Returns alpha, bravo, charlie, ...; from the 27th on robot27, ...
std::string RobotName(size_t index);

// Splits "2:gamma=0.8" into robot and options. Returns INVALID_ARGUMENT for another form.
absl::StatusOr<std::pair<size_t, std::string>> ParsePerturbation(absl::string_view text);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RUN_PLAN_H_
