#include "client_agent/map/provisional_keyframes.h"

#include <gtest/gtest.h>

#include <memory>

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kOwn{5};

void Add(KeyframeId id, Map& map) {
  static const auto camera = std::make_shared<const Camera>();
  Keyframe keyframe;
  keyframe.payload = MakeKeyframePayload(id, 0, 0, camera, {});
  map.AddKeyframe(keyframe);
}

TEST(NewestButTest, CountsOwnKeyframesThatAreThere) {
  Map map;
  for (uint32_t i = 0; i < 5; ++i) {
    Add({kOwn, i}, map);
    // Others' keyframes stand on both sides of them.
    Add({LocalMapId{4}, i}, map);
    Add({LocalMapId{6}, i}, map);
  }
  EXPECT_EQ(NewestBut(map, kOwn, 0), (KeyframeId{kOwn, 4}));
  map.RemoveKeyframe({kOwn, 3});
  EXPECT_EQ(NewestBut(map, kOwn, 1), (KeyframeId{kOwn, 2}));
  EXPECT_EQ(NewestBut(map, kOwn, 3), (KeyframeId{kOwn, 0}));
  EXPECT_FALSE(NewestBut(map, kOwn, 4).IsValid());
  EXPECT_FALSE(NewestBut(Map(), kOwn, 0).IsValid());
}

}  // namespace
}  // namespace corbslam::client_agent
