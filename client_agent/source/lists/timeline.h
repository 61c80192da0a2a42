// Judges whether the times of a sequence can be a camera's, and where they jump.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_TIMELINE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_TIMELINE_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client_agent/source/source_finding.h"

namespace corbslam::client_agent {

// A time as a list gives it.
struct ListedTime {
  int64_t timestamp_ns = 0;
  int line = 0;  // Line of its file, from 1 on.
};

// The entries of a list that are played, in the list's order, and where time jumps back.
struct Timeline {
  std::vector<size_t> kept;
  // The drive of each entry that is kept: 0, and one more from where time falls by more than
  // kJumpBack on: a second drive in the same list, which shares nothing with the first but the
  // camera.
  std::vector<int> drive;
  SourceRemarks remarks;  // Why some are not kept, and where the jumps are.
};

constexpr int64_t kJumpBack_ns = 1'000'000'000;

// Leaves out times that fall by at most kJumpBack, with a warning, if they are few. Returns
// INVALID_ARGUMENT with file and line: a time that is negative, one that is there twice in a row,
// many that do not grow.
absl::StatusOr<Timeline> BuildTimeline(const std::string& path,
                                       const std::vector<ListedTime>& times);

struct TimeStatistics {
  double rate_hz = 0;  // Rate of the median interval.
  double duration_s = 0;
  // Number of intervals of more than ten median ones and more than a second, or of more than five
  // seconds and one and a half median ones; jumps back not among them.
  size_t gaps = 0;
  double longest_gap_s = 0;
  size_t longest_gap_frame = 0;  // Number of the frame behind that gap.
};

// Measures growing times, jumps back aside. Adds a warning for a gap in which a camera moves out of
// its own sight, and for an odd rate. Returns INVALID_ARGUMENT where the times can't be in the unit
// they are read in.
absl::StatusOr<TimeStatistics> MeasureTimes(const std::string& path,
                                            const std::vector<int64_t>& times_ns,
                                            SourceFindings& findings);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LISTS_TIMELINE_H_
