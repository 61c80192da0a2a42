// Keyframe payloads for tests that care for ids and keypoints alone.
#ifndef CORBSLAM_CLIENT_AGENT_MEMORY_TESTING_TEST_PAYLOAD_H_
#define CORBSLAM_CLIENT_AGENT_MEMORY_TESTING_TEST_PAYLOAD_H_

#include <memory>
#include <utility>

#include "slam/map/keyframe.h"

namespace corbslam::testing {

// All keypoints at the origin, without depth.
inline std::shared_ptr<const KeyframePayload> MakeTestPayload(KeyframeId id, size_t keypoints) {
  static const auto camera = std::make_shared<const Camera>(Camera{.fx_px = 500,
                                                                   .fy_px = 500,
                                                                   .cx_px = 320,
                                                                   .cy_px = 240,
                                                                   .width_px = 640,
                                                                   .height_px = 480,
                                                                   .baseline_m = 0.1});
  Features features;
  features.keypoints.resize(keypoints);
  features.descriptors.resize(keypoints);
  return MakeKeyframePayload(id, 0, 0, camera, std::move(features));
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_CLIENT_AGENT_MEMORY_TESTING_TEST_PAYLOAD_H_
