// Watches what a sensor gives while a robot tracks.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_INPUT_WATCH_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_INPUT_WATCH_H_

#include <cstddef>
#include <deque>
#include <optional>

#include "client_agent/source/source_finding.h"
#include "slam/features/keypoint.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// Counts how many features have depth: a pair that is none, or depth that fails, gives hardly any.
// A frame costs one look at each feature. Thread-compatible.
class InputWatch {
 public:
  explicit InputWatch(const SensorCalibration& calibration);

  // Takes the features of the next frame, as Sensor::Process gave them. Returns a finding where the
  // share of features with depth has become implausible over the last frames; the same one is told
  // once, and again only after all was right in between.
  std::optional<SourceFinding> Add(const Features& features);

 private:
  struct Count {
    size_t features = 0;
    size_t with_depth = 0;
    size_t at_infinity = 0;  // Stereo points without parallax.
  };
  std::optional<SourceFinding> Judge() const;

  const bool is_stereo_;
  std::deque<Count> window_;
  Count sum_;
  bool is_start_ = true;  // True until the window is full for the first time.
  bool told_ = false;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_INPUT_WATCH_H_
