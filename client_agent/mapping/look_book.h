// What frames measured that became no keyframe, on its way into the keyframes that stay
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

namespace corbslam {

// Another measurement of what a keyframe's keypoint sees, in the keyframe's pixels.
struct Look {
  KeyframeId keyframe;
  uint32_t keypoint = 0;
  // From the keypoint to where this one would have it.
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  double disparity_shift_px = 0;
  // Greater than 0.
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
// One a keypoint, up to the last one that was looked at.
using KeyframeLooks = std::vector<LookSum>;

// The keypoints where they and the looks at them are on the average.
std::vector<Keypoint> Averaged(std::vector<Keypoint> keypoints, const KeyframeLooks& looks);

// Of one local map. Thread-safe: tracking adds, mapping takes.
class LookBook {
 public:
  // Those of keyframes whose looks were taken come too late, and are passed over: their keypoints
  // are not those any more that were looked at.
  void Add(const std::vector<Look>& looks);
  // Those of keyframes up to this one, once.
  absl::btree_map<KeyframeId, KeyframeLooks> TakeUpTo(KeyframeId last);

 private:
  absl::Mutex mutex_;
  absl::btree_map<KeyframeId, KeyframeLooks> looks_ ABSL_GUARDED_BY(mutex_);
  // Up to here looks were taken; nullopt: none was.
  std::optional<KeyframeId> taken_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_LOOK_BOOK_H_
