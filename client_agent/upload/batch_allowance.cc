#include "client_agent/upload/batch_allowance.h"

namespace corbslam::client_agent {
namespace {

// These sizes were measured (docs/wire.md). A codec makes items smaller, which the scale tells.
constexpr size_t kBatchBytes = 64;
constexpr size_t kCameraBytes = 256;
constexpr size_t kKeyframeBytes = 128;
constexpr size_t kKeypointBytes = 42;
constexpr size_t kPointBytes = 64;
constexpr size_t kLightKeyframeBytes = 76;
constexpr size_t kLightPointBytes = 15;
constexpr size_t kObservationBytes = 5;
constexpr size_t kIdBytes = 6;
constexpr size_t kEdgeBytes = 90;
constexpr size_t kFrameBytes = 48;

}  // namespace

size_t EstimateWireBytes(const MapUpdateBatch& batch) {
  size_t bytes = kBatchBytes + kCameraBytes * batch.cameras.size();
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    bytes += kKeyframeBytes + kKeypointBytes * keyframe.payload->features.keypoints.size();
  }
  bytes += kPointBytes * batch.full_points.size();
  bytes += kLightKeyframeBytes * batch.light_keyframes.size();
  bytes += kLightPointBytes * batch.light_points.size();
  bytes += 2 * kIdBytes * batch.replacements.size();
  bytes += kObservationBytes * batch.observations.size();
  bytes += kIdBytes * batch.removed_points.size();
  bytes += kEdgeBytes * (batch.removed_keyframes.size() + batch.loop_edges.size());
  bytes += kFrameBytes * batch.tracked_frames.size();
  bytes += sizeof(int64_t) * batch.lost_frames_ns.size();
  return bytes;
}

void BatchAllowance::SpendPoses(size_t light_keyframes, size_t frames) {
  left_ -= static_cast<double>(kLightKeyframeBytes * light_keyframes + kFrameBytes * frames);
}

void BatchAllowance::SpendKeyframe(size_t keypoints) {
  left_ -= static_cast<double>(kKeyframeBytes + kKeypointBytes * keypoints);
}

void BatchAllowance::SpendPoint(size_t observations) {
  left_ -= static_cast<double>(kPointBytes + kObservationBytes * observations);
}

void BatchAllowance::SpendLightPoint() { left_ -= static_cast<double>(kLightPointBytes); }

}  // namespace corbslam::client_agent
