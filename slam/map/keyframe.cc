#include "slam/map/keyframe.h"

#include <utility>

namespace corbslam {

std::shared_ptr<const KeyframePayload> MakeKeyframePayload(KeyframePayload payload) {
  payload.grid = FeatureGrid(*payload.camera, payload.features.keypoints);
  return std::make_shared<const KeyframePayload>(std::move(payload));
}

std::shared_ptr<const KeyframePayload> MakeKeyframePayload(KeyframeId id, int64_t timestamp_ns,
                                                           uint32_t camera_index,
                                                           std::shared_ptr<const Camera> camera,
                                                           Features features) {
  KeyframePayload payload;
  payload.id = id;
  payload.timestamp_ns = timestamp_ns;
  payload.camera_index = camera_index;
  payload.camera = std::move(camera);
  payload.features = std::move(features);
  return MakeKeyframePayload(std::move(payload));
}

std::shared_ptr<const KeyframePayload> WithFeatures(const KeyframePayload& payload,
                                                    Features features) {
  KeyframePayload other = payload;
  other.features = std::move(features);
  other.code.reset();
  return MakeKeyframePayload(std::move(other));
}

std::shared_ptr<const KeyframePayload> WithCamera(const KeyframePayload& payload,
                                                  std::shared_ptr<const Camera> camera) {
  KeyframePayload other = payload;
  other.camera = std::move(camera);
  return MakeKeyframePayload(std::move(other));
}

}  // namespace corbslam
