// Reads what `corbslam eval` compares: estimates and the truth, of one frame.
#ifndef CORBSLAM_SERVICES_TOOL_EVALUATION_EVALUATION_INPUT_H_
#define CORBSLAM_SERVICES_TOOL_EVALUATION_EVALUATION_INPUT_H_

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/evaluation/trajectory.h"

namespace corbslam::services {

struct EvaluationFiles {
  // LAYOUT:DIR of a sequence, or a file (ReadTrajectoryFile), each: one for all estimates, or one
  // for each of them, in their order. Where the truths are in one frame there may be other numbers
  // of them, each of a time of its own.
  std::vector<std::string> truths;
  bool is_truth_shared = false;  // The truths are in one frame.
  std::string truth_times;       // Of the only truth.
  std::vector<std::string> estimates;
  // "camera", "rectified" or "body". Empty: the frame that the estimates say, or else the camera.
  std::string poses_of;
  std::optional<size_t> from_frame;
};

struct EvaluationInput {
  std::vector<Trajectory> truths;     // One for all estimates, or one for each.
  bool is_one_frame = false;          // True: one alignment may serve for all.
  std::vector<Trajectory> estimates;  // In the order of the files.
  // A sentence for each kind of what was left out or put in order.
  std::vector<std::string> notes;

  // Returns the truth of an estimate.
  const Trajectory& TruthOf(size_t estimate) const {
    return truths.size() == 1 ? truths.front() : truths[estimate];
  }
};

// Returns INVALID_ARGUMENT, which names the file, if the estimates are of different frames, if the
// truth is of another one, if a file can't be read, or if nothing says which truth is whose. A
// sequence's truth is taken in the frame that the estimates are of; FAILED_PRECONDITION if its
// calibration doesn't know that frame.
absl::StatusOr<EvaluationInput> ReadEvaluationInput(const EvaluationFiles& files);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_EVALUATION_INPUT_H_
