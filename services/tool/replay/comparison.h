// Compares what tracking said of each frame of a recording with what it says when that is played
// again.
#ifndef CORBSLAM_SERVICES_TOOL_REPLAY_COMPARISON_H_
#define CORBSLAM_SERVICES_TOOL_REPLAY_COMPARISON_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client_agent/tracking/tracking_result.h"

namespace corbslam::services {

// One result a frame; nullopt where there is none.
using FrameResults = std::vector<std::optional<client_agent::TrackingResult>>;

// A change of the state, or another local map.
struct TrackingEvent {
  size_t frame = 0;
  std::string what;

  bool operator==(const TrackingEvent&) const = default;
};

struct PoseDifference {
  size_t frame = 0;
  double position_m = 0;
  double angle_deg = 0;
};

struct ReplayComparison {
  size_t compared = 0;  // Frames with both results.
  size_t equal = 0;     // Of these, equal to the digit.
  std::optional<size_t> first_different;
  // Of poses whose local maps began at the same frame: others have nothing in common. The first and
  // the largest by position; nullopt where no pose differs.
  std::optional<PoseDifference> first_pose;
  std::optional<PoseDifference> largest_pose;
  std::vector<TrackingEvent> recorded_events;
  std::vector<TrackingEvent> replayed_events;

  bool AllEqual() const { return equal == compared; }
};

// Both have one entry for each frame.
ReplayComparison CompareResults(const FrameResults& recorded, const FrameResults& replayed);

// Returns a number of all results, the same for the same results to the bit (FNV-1a).
uint64_t DigestOf(const FrameResults& results);

// Returns sentences about the comparison, a line each.
std::string FormatComparison(const ReplayComparison& comparison);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_REPLAY_COMPARISON_H_
