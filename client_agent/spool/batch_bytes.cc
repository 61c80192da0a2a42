#include "client_agent/spool/batch_bytes.h"

#include <cstdint>

namespace corbslam::client_agent {

size_t ApproximateBytes(const MapUpdateBatch& batch) {
  constexpr size_t kFeatureBytes = sizeof(Keypoint) + sizeof(Descriptor);
  size_t bytes = 64;
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    bytes += 128 + kFeatureBytes * keyframe.payload->features.keypoints.size();
  }
  bytes += batch.cameras.size() * sizeof(Camera);
  bytes += batch.full_points.size() * sizeof(FullMapPoint);
  bytes += batch.light_keyframes.size() * sizeof(LightKeyframe);
  bytes += batch.light_points.size() * sizeof(LightMapPoint);
  bytes += batch.replacements.size() * sizeof(PointReplacement);
  bytes += batch.observations.size() * sizeof(ObservationChange);
  bytes += batch.removed_points.size() * sizeof(MapPointId);
  bytes += batch.removed_keyframes.size() * sizeof(KeyframeRemoval);
  bytes += batch.loop_edges.size() * sizeof(LoopEdge);
  bytes += batch.tracked_frames.size() * sizeof(TrackedFrame);
  bytes += batch.lost_frames_ns.size() * sizeof(int64_t);
  return bytes;
}

}  // namespace corbslam::client_agent
