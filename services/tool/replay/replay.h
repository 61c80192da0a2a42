// Plays a recording again through the estimator that recorded it (docs/recording.md).
#ifndef CORBSLAM_SERVICES_TOOL_REPLAY_REPLAY_H_
#define CORBSLAM_SERVICES_TOOL_REPLAY_REPLAY_H_

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/agent/agent.h"
#include "services/programs/recording/recording.h"
#include "services/tool/replay/comparison.h"

namespace corbslam::services {

struct ReplayOptions {
  std::string vocabulary_path;                               // Empty: the one that ships.
  std::function<void(size_t done, size_t all)> on_progress;  // May be null.
};

struct Replayed {
  FrameResults results;                        // One for each recorded frame.
  std::vector<std::string> notes;              // What is not as it was recorded.
  std::unique_ptr<client_agent::Agent> agent;  // Has finished.
};

// Plays all frames in lockstep, with the recorded flags, on one thread: the results are the same to
// the bit each time. A frame whose pictures can't be read is left out, with a note.
// INVALID_ARGUMENT for impossible flags or a calibration that none has; FAILED_PRECONDITION for a
// robot that only localised, which says how its pictures can be played instead.
absl::StatusOr<Replayed> Replay(const Recording& recording, const ReplayOptions& options);

// Returns the recorded results.
FrameResults ResultsOf(const Recording& recording);

// Returns why poses may differ from those recorded, though the program is right; empty where they
// must be equal to the digit.
std::vector<std::string> ReasonsToDiffer(const Recording& recording, const Replayed& replayed,
                                         const std::string& version);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPLAY_REPLAY_H_
