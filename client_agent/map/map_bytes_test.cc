#include "client_agent/map/map_bytes.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

namespace corbslam::client_agent {
namespace {

void AddKeyframe(KeyframeId id, size_t keypoints, Map& map) {
  Features features;
  features.keypoints.resize(keypoints, {.x_px = 10, .y_px = 10});
  features.descriptors.resize(keypoints);
  Keyframe keyframe;
  auto camera = std::make_shared<Camera>();
  camera->width_px = camera->height_px = 100;
  keyframe.payload = MakeKeyframePayload(id, 0, 0, std::move(camera), std::move(features));
  map.AddKeyframe(std::move(keyframe));
}

TEST(MapBytesTest, CountsKeypointsAndPointsWhoseverTheyAre) {
  Map map;
  EXPECT_EQ(EstimateBytes(map), 0u);
  AddKeyframe({{1}, 0}, 1000, map);
  const uint64_t own = EstimateBytes(map);
  // A keypoint with its descriptor alone has 52 bytes.
  EXPECT_GT(own, 52'000u);
  EXPECT_LT(own, 1'000'000u);
  AddKeyframe({{2}, 0}, 1000, map);
  EXPECT_EQ(EstimateBytes(map), 2 * own) << "others' are held in the same way";
  const uint64_t before = EstimateBytes(map);
  for (uint32_t i = 0; i < 1000; ++i) {
    MapPoint point;
    point.id = {{1}, i};
    map.AddPoint(std::move(point));
  }
  EXPECT_GE(EstimateBytes(map), before + 1000 * sizeof(MapPoint));
  map.RemoveKeyframe({{2}, 0});
  for (uint32_t i = 0; i < 1000; ++i) map.RemovePoint({{1}, i});
  EXPECT_EQ(EstimateBytes(map), own) << "what goes is not counted";
}

}  // namespace
}  // namespace corbslam::client_agent
