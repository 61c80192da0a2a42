#include "client_agent/mapping/nearest_keypoints.h"

#include <algorithm>

namespace corbslam::client_agent {

std::vector<uint32_t> NearestKeypoints(const Camera& camera, const std::vector<Keypoint>& keypoints,
                                       size_t at_least) {
  std::vector<uint32_t> nearest;
  if (!camera.IsMetric()) return nearest;
  for (size_t i = 0; i < keypoints.size(); ++i) {
    if (keypoints[i].HasDepth()) nearest.push_back(static_cast<uint32_t>(i));
  }
  std::stable_sort(nearest.begin(), nearest.end(), [&](uint32_t a, uint32_t b) {
    return keypoints[a].disparity_px > keypoints[b].disparity_px;
  });
  const double least_disparity_px = DisparityFromDepth(camera, camera.close_depth_m);
  const auto far = std::partition_point(nearest.begin(), nearest.end(), [&](uint32_t i) {
    return keypoints[i].disparity_px > least_disparity_px;
  });
  const size_t close = static_cast<size_t>(far - nearest.begin());
  nearest.resize(std::min(nearest.size(), std::max(close, at_least)));
  return nearest;
}

}  // namespace corbslam::client_agent
