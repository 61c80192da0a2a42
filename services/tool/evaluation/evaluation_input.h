// What `corbslam eval` holds against each other: estimates and the truth, of one frame.
#ifndef CORBSLAM_SERVICES_TOOL_EVALUATION_EVALUATION_INPUT_H_
#define CORBSLAM_SERVICES_TOOL_EVALUATION_EVALUATION_INPUT_H_

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/evaluation/trajectory.h"

namespace corbslam {

struct EvaluationFiles {
  // A sequence as LAYOUT:DIR, or a file (ReadTrajectoryFile).
  std::string truth;
  std::string truth_times;
  std::vector<std::string> estimates;
  // "camera", "rectified" or "body"; empty: what the estimates say, or else the camera.
  std::string poses_of;
  std::optional<size_t> from_frame;
};

struct EvaluationInput {
  Trajectory truth;
  std::vector<Trajectory> estimates;  // In the order of the files.
  // What was left out or put in order, a sentence each.
  std::vector<std::string> notes;
};

// INVALID_ARGUMENT names the file: the estimates are of different frames, or the truth is of
// another one; a file can't be read. Of a sequence the truth is that of the frame that the
// estimates are of; FAILED_PRECONDITION where its calibration doesn't know it.
absl::StatusOr<EvaluationInput> ReadEvaluationInput(const EvaluationFiles& files);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_EVALUATION_INPUT_H_
