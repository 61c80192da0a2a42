// Takes a sample of what a live camera gives, and measures how it gives it.
#ifndef CORBSLAM_SERVICES_TOOL_RIG_LIVE_SAMPLE_H_
#define CORBSLAM_SERVICES_TOOL_RIG_LIVE_SAMPLE_H_

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/sample.h"

namespace corbslam::services {

struct LiveSample {
  client_agent::Sample frames;
  size_t taken = 0;    // Frames that were taken from the stream, in the sample or not.
  double rate_hz = 0;  // Of all frames that came, by their own times.
  double seconds = 0;  // From the first frame taken to the last.
  size_t clocks = 1;  // By which its times went, one after the other; the measures are of the last.
  size_t gaps = 0;    // Frames that came later than half an interval after they should.
  double longest_s = 0;  // Longest time between two frames that followed each other.
  std::optional<client_agent::CameraCounts> counts;
  client_agent::LeftOutFrames left_out;
  absl::Status ended;  // Why the camera gave no more before the time was over.
};

// Takes frames for `duration`, or until the stream ends. Places are spread over that time, with
// as many frames in a row as `options` say. UNAVAILABLE without a frame, unless the stream's own
// error says why.
absl::StatusOr<LiveSample> TakeLiveSample(client_agent::FrameStream& stream,
                                          absl::Duration duration,
                                          const client_agent::SampleOptions& options);

// Returns names and values for people: rate, gaps, frames that were missed, times apart.
std::vector<std::pair<std::string, std::string>> DescribeInLines(const LiveSample& sample);

// Finds a rate far below `expected_hz`, gaps, times of several clocks, pictures without a
// counterpart, a camera that failed.
client_agent::SourceFindings CheckLiveSample(const LiveSample& sample,
                                             std::optional<double> expected_hz);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_RIG_LIVE_SAMPLE_H_
