// Keeps what frames measured that became no keyframe, on its way into the keyframes that stay
// (docs/adr/0012-provisional-keyframes.md).
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_MEASUREMENT_BOOK_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_MEASUREMENT_BOOK_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/container/btree_map.h"
#include "absl/synchronization/mutex.h"
#include "slam/features/keypoint.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// Another measurement of what a keyframe's keypoint sees, in the keyframe's pixels.
struct KeypointMeasurement {
  KeyframeId keyframe;
  uint32_t keypoint = 0;
  // Shift from the keypoint to where this measurement has it.
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  double disparity_shift_px = 0;
  // The variance is greater than 0.
  double variance_px2 = 0;
  // 0: no disparity was measured.
  double disparity_variance_px2 = 0;
};

// The measurements of one keypoint, weighted by their variances.
struct MeasurementSum {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double weight = 0;
  double disparity_shift = 0;
  double disparity_weight = 0;
};
// One sum a keypoint, up to the last one that was measured.
using KeyframeMeasurements = std::vector<MeasurementSum>;

// Returns the keypoints at the weighted mean of their own measurement and the further ones.
std::vector<Keypoint> Averaged(std::vector<Keypoint> keypoints,
                               const KeyframeMeasurements& measurements);

// The measurement book of one local map. Thread-safe: tracking adds, mapping takes.
class MeasurementBook {
 public:
  // Adds measurements. Those of keyframes whose measurements were taken already come too late and
  // are passed over, because the keypoints were moved since.
  void Add(const std::vector<KeypointMeasurement>& measurements);
  // Takes the measurements of keyframes up to `last`; each measurement is taken once.
  absl::btree_map<KeyframeId, KeyframeMeasurements> TakeUpTo(KeyframeId last);

 private:
  absl::Mutex mutex_;
  absl::btree_map<KeyframeId, KeyframeMeasurements> measurements_ ABSL_GUARDED_BY(mutex_);
  // The measurements were taken up to this keyframe; nullopt: none was taken.
  std::optional<KeyframeId> taken_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_MEASUREMENT_BOOK_H_
