// Keeps what frames measured that became no keyframe, on its way into the keyframes that stay
// (docs/adr/0012-provisional-keyframes.md).
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_LOOK_BOOK_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_LOOK_BOOK_H_

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
struct Look {
  KeyframeId keyframe;
  uint32_t keypoint = 0;
  // Shift from the keypoint to where this look has it.
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  double disparity_shift_px = 0;
  // It is greater than 0.
  double variance_px2 = 0;
  // 0: no disparity was measured.
  double disparity_variance_px2 = 0;
};

// The looks at one keypoint, weighted by their variances.
struct LookSum {
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  double weight = 0;
  double disparity_shift = 0;
  double disparity_weight = 0;
};
// One sum a keypoint, up to the last one that was looked at.
using KeyframeLooks = std::vector<LookSum>;

// Returns the keypoints at the weighted mean of their own measurement and the looks at them.
std::vector<Keypoint> Averaged(std::vector<Keypoint> keypoints, const KeyframeLooks& looks);

// The look book of one local map. Thread-safe: tracking adds, mapping takes.
class LookBook {
 public:
  // Adds looks. Those at keyframes whose looks were taken already come too late and are passed
  // over, because their keypoints were moved since.
  void Add(const std::vector<Look>& looks);
  // Takes the looks at keyframes up to `last`; each look is taken once.
  absl::btree_map<KeyframeId, KeyframeLooks> TakeUpTo(KeyframeId last);

 private:
  absl::Mutex mutex_;
  absl::btree_map<KeyframeId, KeyframeLooks> looks_ ABSL_GUARDED_BY(mutex_);
  // The looks were taken up to this keyframe; nullopt: none was taken.
  std::optional<KeyframeId> taken_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_LOOK_BOOK_H_
