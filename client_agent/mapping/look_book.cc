#include "client_agent/mapping/look_book.h"

#include <algorithm>

namespace corbslam::client_agent {
namespace {

void AddDisparity(const LookSum& looks, double own_weight, Keypoint& keypoint) {
  if (looks.disparity_weight <= 0 || !keypoint.HasDepth()) return;
  const auto disparity_px = static_cast<float>(
      keypoint.disparity_px + looks.disparity_shift / (own_weight + looks.disparity_weight));
  // The disparity of a point that is too far to have one may become 0 or less by noise.
  if (disparity_px > 0) keypoint.disparity_px = disparity_px;
}

}  // namespace

std::vector<Keypoint> Averaged(std::vector<Keypoint> keypoints, const KeyframeLooks& looks) {
  for (size_t i = 0; i < std::min(keypoints.size(), looks.size()); ++i) {
    if (looks[i].weight <= 0) continue;
    const double own_weight = 1 / ScalePyramid::Variance_px2(keypoints[i].octave);
    const Eigen::Vector2d shift_px = looks[i].shift / (own_weight + looks[i].weight);
    keypoints[i].x_px += static_cast<float>(shift_px.x());
    keypoints[i].y_px += static_cast<float>(shift_px.y());
    AddDisparity(looks[i], own_weight, keypoints[i]);
  }
  return keypoints;
}

void LookBook::Add(const std::vector<Look>& looks) {
  absl::MutexLock lock(&mutex_);
  for (const Look& look : looks) {
    if (taken_.has_value() && look.keyframe <= *taken_) continue;
    KeyframeLooks& sums = looks_[look.keyframe];
    if (sums.size() <= look.keypoint) sums.resize(look.keypoint + 1);
    LookSum& sum = sums[look.keypoint];
    sum.shift += look.shift_px / look.variance_px2;
    sum.weight += 1 / look.variance_px2;
    if (look.disparity_variance_px2 <= 0) continue;
    sum.disparity_shift += look.disparity_shift_px / look.disparity_variance_px2;
    sum.disparity_weight += 1 / look.disparity_variance_px2;
  }
}

absl::btree_map<KeyframeId, KeyframeLooks> LookBook::TakeUpTo(KeyframeId last) {
  absl::MutexLock lock(&mutex_);
  // Where keyframes were culled meanwhile, `last` may lie before the last time's.
  taken_ = std::max(taken_.value_or(last), last);
  absl::btree_map<KeyframeId, KeyframeLooks> taken;
  while (!looks_.empty() && looks_.begin()->first <= last) {
    taken.insert(looks_.extract(looks_.begin()));
  }
  return taken;
}

}  // namespace corbslam::client_agent
