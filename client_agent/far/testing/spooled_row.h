// Makes a local map of keyframes in a row, for tests of what comes back from the disk.
#ifndef CORBSLAM_CLIENT_AGENT_FAR_TESTING_SPOOLED_ROW_H_
#define CORBSLAM_CLIENT_AGENT_FAR_TESTING_SPOOLED_ROW_H_

#include <gtest/gtest.h>

#include <utility>

#include "client_agent/upload/spooled_map.h"
#include "slam/camera/testing/test_camera.h"

namespace corbslam::client_agent {

// Keyframe i stands at x = i + `begin_m`, a child of the one before, and sees the points i and
// i + 1. Its descriptors begin with the word `begin_m` + i, so that each looks like no other.
inline SpooledMap SpooledRow(LocalMapId local_map, uint32_t keyframes, uint32_t begin_m = 0) {
  MapUpdateBatch batch;
  batch.local_map = local_map;
  batch.cameras.push_back(testing::TestCamera());
  for (uint32_t i = 0; i < keyframes; ++i) {
    Features features;
    features.keypoints.resize(2);
    features.descriptors.resize(2);
    for (Descriptor& descriptor : features.descriptors) descriptor.words[0] = begin_m + i;
    const Rigid3d pose = {Eigen::Quaterniond::Identity(),
                          Eigen::Vector3d(-static_cast<double>(begin_m + i), 0, 0)};
    batch.full_keyframes.push_back(
        {MakeKeyframePayload({local_map, i}, i, 0, testing::TestCamera(), std::move(features)),
         pose, i == 0 ? KeyframeId() : KeyframeId{local_map, i - 1}});
  }
  for (uint32_t i = 0; i <= keyframes; ++i) {
    FullMapPoint point;
    point.id = {local_map, i};
    point.reference = {local_map, i == keyframes ? i - 1 : i};
    point.position_in_local = {static_cast<double>(begin_m + i), 0, 5};
    point.normal_in_local = {0, 0, 1};
    point.max_distance = 10;
    batch.full_points.push_back(point);
  }
  for (uint32_t i = 0; i < keyframes; ++i) {
    for (uint32_t k = 0; k < 2; ++k) {
      batch.observations.push_back(
          {ObservationChange::Kind::kAdded, {local_map, i + k}, {local_map, i}, k});
    }
  }
  SpooledMap spooled_map(local_map);
  const absl::Status applied = spooled_map.Apply(batch);
  EXPECT_TRUE(applied.ok()) << applied;
  return spooled_map;
}

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_FAR_TESTING_SPOOLED_ROW_H_
