#include "client_agent/mapping/measurement_book.h"

#include <algorithm>

namespace corbslam::client_agent {
namespace {

void AddDisparity(const MeasurementSum& measurements, double own_weight, Keypoint& keypoint) {
  if (measurements.disparity_weight <= 0 || !keypoint.HasDepth()) return;
  const auto disparity_px =
      static_cast<float>(keypoint.disparity_px + measurements.disparity_shift /
                                                     (own_weight + measurements.disparity_weight));
  // The disparity of a point that is too far to have one may become 0 or less by noise.
  if (disparity_px > 0) keypoint.disparity_px = disparity_px;
}

}  // namespace

std::vector<Keypoint> Averaged(std::vector<Keypoint> keypoints,
                               const KeyframeMeasurements& measurements) {
  for (size_t i = 0; i < std::min(keypoints.size(), measurements.size()); ++i) {
    if (measurements[i].weight <= 0) continue;
    const double own_weight = 1 / ScalePyramid::Variance_px2(keypoints[i].octave);
    const Eigen::Vector2d shift_px = measurements[i].shift / (own_weight + measurements[i].weight);
    keypoints[i].x_px += static_cast<float>(shift_px.x());
    keypoints[i].y_px += static_cast<float>(shift_px.y());
    AddDisparity(measurements[i], own_weight, keypoints[i]);
  }
  return keypoints;
}

void MeasurementBook::Add(const std::vector<KeypointMeasurement>& measurements) {
  absl::MutexLock lock(&mutex_);
  for (const KeypointMeasurement& measurement : measurements) {
    if (taken_.has_value() && measurement.keyframe <= *taken_) continue;
    KeyframeMeasurements& sums = measurements_[measurement.keyframe];
    if (sums.size() <= measurement.keypoint) sums.resize(measurement.keypoint + 1);
    MeasurementSum& sum = sums[measurement.keypoint];
    sum.shift += measurement.shift_px / measurement.variance_px2;
    sum.weight += 1 / measurement.variance_px2;
    if (measurement.disparity_variance_px2 <= 0) continue;
    sum.disparity_shift += measurement.disparity_shift_px / measurement.disparity_variance_px2;
    sum.disparity_weight += 1 / measurement.disparity_variance_px2;
  }
}

absl::btree_map<KeyframeId, KeyframeMeasurements> MeasurementBook::TakeUpTo(KeyframeId last) {
  absl::MutexLock lock(&mutex_);
  // Where keyframes were culled meanwhile, `last` may lie before the last time's.
  taken_ = std::max(taken_.value_or(last), last);
  absl::btree_map<KeyframeId, KeyframeMeasurements> taken;
  while (!measurements_.empty() && measurements_.begin()->first <= last) {
    taken.insert(measurements_.extract(measurements_.begin()));
  }
  return taken;
}

}  // namespace corbslam::client_agent
