// Says how much one batch may carry, and about what each item of it takes on the wire.
#ifndef CORBSLAM_CLIENT_AGENT_UPLOAD_BATCH_ALLOWANCE_H_
#define CORBSLAM_CLIENT_AGENT_UPLOAD_BATCH_ALLOWANCE_H_

#include <cstddef>
#include <limits>

#include "slam/exchange/map_update.h"

namespace corbslam::client_agent {

// Returns about how many bytes a batch takes on the wire, as BatchAllowance counts them at a scale
// of 1.
size_t EstimateWireBytes(const MapUpdateBatch& batch);

// The bytes that one batch may take. They are spent in the order of what matters most
// (docs/adr/0019-link-budgets.md): poses, full keyframes, points, light points. An item goes while
// anything is left, so that the last one may take more than there was. Not thread-safe.
class BatchAllowance {
 public:
  // Bounds the number of full keyframes alone.
  explicit BatchAllowance(size_t max_keyframes) : max_keyframes_(max_keyframes) {}
  // `scale` is what an item really takes, as a share of the estimate.
  BatchAllowance(size_t max_keyframes, double bytes, double scale)
      : max_keyframes_(max_keyframes), left_(bytes / scale) {}

  size_t max_keyframes() const { return max_keyframes_; }
  bool is_spent() const { return left_ <= 0; }

  // Poses always go, and are spent first.
  void SpendPoses(size_t light_keyframes, size_t frames);
  void SpendKeyframe(size_t keypoints);
  // Spends a full point with the observations that come with it.
  void SpendPoint(size_t observations);
  void SpendLightPoint();

 private:
  size_t max_keyframes_;
  // Bytes that are left, at a scale of 1.
  double left_ = std::numeric_limits<double>::infinity();
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_UPLOAD_BATCH_ALLOWANCE_H_
