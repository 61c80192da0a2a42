// Looks at the frames of a live pair in passing for a camera that is late.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_LATE_WATCH_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_LATE_WATCH_H_

#include <cstddef>
#include <future>
#include <optional>

#include "absl/time/time.h"
#include "client_agent/source/frame_stream.h"
#include "client_agent/source/source_finding.h"
#include "client_agent/source_checks/sample.h"
#include "client_agent/source_checks/stereo_checks.h"

namespace corbslam::client_agent {

// Three frames hardly show a late camera, and a robot that stands shows none: frames in a row are
// judged a few times, on a thread of their own, while the stream goes on. One thread uses it.
class LateWatch {
 public:
  static constexpr size_t kFrames = 8;
  static constexpr int kMostLooks = 5;
  static constexpr absl::Duration kBetweenLooks = absl::Seconds(2);

  explicit LateWatch(const SensorCalibration& calibration) : calibration_(calibration) {}

  // Notes a frame that passes. Its pictures are kept for a while: nobody may change them.
  void Offer(const StreamFrame& frame, absl::Time now);
  // Returns what a look found since the last call, once; `waits` for one that is under way.
  std::optional<SourceFinding> Take(bool waits, absl::Time now);

 private:
  const SensorCalibration calibration_;
  Sample row_;
  int looks_ = 0;
  absl::Time next_ = absl::InfinitePast();
  std::future<StereoJudgement> look_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_LATE_WATCH_H_
