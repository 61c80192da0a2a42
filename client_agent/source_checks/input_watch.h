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
// A frame costs one look at each feature; of one camera alone nothing is counted. Says, too, where
// a pair's rows had to be put right. Thread-compatible.
class InputWatch {
 public:
  explicit InputWatch(const SensorCalibration& calibration);

  // Takes the features of the next frame, as Sensor::Process gave them. Returns a finding where the
  // share of features with depth has become implausible over the last frames; the same one is told
  // once, and again only after all was right in between.
  std::optional<SourceFinding> Add(const Features& features);
  // Takes by how many rows the sensor moves the right pictures (Sensor::row_correction_px). Returns
  // a finding where that is 0.1 rows from what was told last, or from none.
  std::optional<SourceFinding> AddRows(double correction_px);

 private:
  struct Count {
    size_t features = 0;
    size_t with_depth = 0;
    size_t at_infinity = 0;  // Stereo points without parallax.
  };
  std::optional<SourceFinding> Judge() const;

  const SensorKind kind_;
  std::deque<Count> window_;
  Count sum_;
  bool is_start_ = true;  // True until the window is full for the first time.
  bool told_ = false;
  double told_rows_px_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_CHECKS_INPUT_WATCH_H_
