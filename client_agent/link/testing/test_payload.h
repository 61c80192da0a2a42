// Makes keyframe payloads for tests that care for ids and keypoints alone.
#ifndef CORBSLAM_CLIENT_AGENT_LINK_TESTING_TEST_PAYLOAD_H_
#define CORBSLAM_CLIENT_AGENT_LINK_TESTING_TEST_PAYLOAD_H_

#include <memory>
#include <utility>

#include "slam/camera/testing/test_camera.h"
#include "slam/map/keyframe.h"

namespace corbslam::testing {

// Returns a payload with all keypoints at the origin, without depth.
inline std::shared_ptr<const KeyframePayload> MakeTestPayload(KeyframeId id, size_t keypoints) {
  Features features;
  features.keypoints.resize(keypoints);
  features.descriptors.resize(keypoints);
  return MakeKeyframePayload(id, 0, 0, TestCamera(), std::move(features));
}

}  // namespace corbslam::testing

#endif  // CORBSLAM_CLIENT_AGENT_LINK_TESTING_TEST_PAYLOAD_H_
