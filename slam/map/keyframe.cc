#include "slam/map/keyframe.h"

#include <utility>

namespace corbslam {

std::shared_ptr<const KeyframePayload> MakeKeyframePayload(KeyframeId id, int64_t timestamp_ns,
                                                           uint32_t camera_index,
                                                           std::shared_ptr<const Camera> camera,
                                                           Features features,
                                                           std::weak_ptr<const std::string> code) {
  auto payload = std::make_shared<KeyframePayload>();
  payload->id = id;
  payload->timestamp_ns = timestamp_ns;
  payload->camera_index = camera_index;
  payload->grid = FeatureGrid(*camera, features.keypoints);
  payload->camera = std::move(camera);
  payload->features = std::move(features);
  payload->code = std::move(code);
  return payload;
}

}  // namespace corbslam
