#include "client_agent/map/near_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>

namespace corbslam::client_agent {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr LocalMapId kOwn = {1};
constexpr LocalMapId kOther = {2};

// Points of the robot and of another one, and keyframes of both, each a metre after the one before
// along x: the robot's from 0 on, the other's from 0.5 on.
class NearMapTest : public ::testing::Test {
 protected:
  void Fill(uint32_t count) {
    map_.Write([&](Map& map) {
      for (uint32_t i = 0; i < count; ++i) {
        for (const LocalMapId id : {kOwn, kOther}) {
          const double x = i + (id == kOwn ? 0 : 0.5);
          MapPoint point;
          point.id = {id, i};
          point.position_in_map = {x, 0, 0};
          map.AddPoint(std::move(point));
          Keyframe keyframe;
          keyframe.payload =
              MakeKeyframePayload({id, i}, i, 0, std::make_shared<const Camera>(), {});
          keyframe.camera_from_map.translation = {-x, 0, 0};
          map.AddKeyframe(std::move(keyframe));
        }
      }
    });
  }

  GuardedMap map_{kOwn};
};

TEST_F(NearMapTest, TheRadiusCountsAndWhoseItIsIsSaid) {
  Fill(10);
  const NearMap near = FindNearMap(map_, {2, 0, 0}, {.radius_m = 1.6});
  EXPECT_EQ(near.local_map, kOwn);
  EXPECT_FALSE(near.truncated);
  ASSERT_THAT(near.own_points, SizeIs(3));  // At 1, 2 and 3.
  EXPECT_EQ(near.own_points[0].x(), 2);
  ASSERT_THAT(near.shared_points, SizeIs(4));  // At 0.5, 1.5, 2.5 and 3.5.
  ASSERT_THAT(near.keyframes, SizeIs(7));
  EXPECT_EQ(near.keyframes[0].id, (KeyframeId{kOwn, 2}));
  EXPECT_FALSE(near.keyframes[0].shared);
  EXPECT_EQ(near.keyframes[0].local_from_camera.translation.x(), 2);
  EXPECT_TRUE(near.keyframes[1].shared);
}

TEST_F(NearMapTest, TheNearestAreKeptAndTheRestIsNotKeptSecret) {
  Fill(10);
  NearMap near = FindNearMap(map_, {0, 0, 0}, {.radius_m = 100, .max_points = 3});
  EXPECT_TRUE(near.truncated);
  ASSERT_THAT(near.own_points, SizeIs(2));
  EXPECT_EQ(near.own_points[1].x(), 1);
  ASSERT_THAT(near.shared_points, SizeIs(1));
  EXPECT_EQ(near.shared_points[0].x(), 0.5f);
  EXPECT_THAT(near.keyframes, SizeIs(20));
  near = FindNearMap(map_, {0, 0, 0}, {.radius_m = 100, .max_keyframes = 4});
  EXPECT_TRUE(near.truncated);
  EXPECT_THAT(near.own_points, SizeIs(10));
  ASSERT_THAT(near.keyframes, SizeIs(4));
  EXPECT_EQ(near.keyframes[3].id, (KeyframeId{kOther, 1}));
  EXPECT_FALSE(FindNearMap(map_, {0, 0, 0}, {.radius_m = 100, .max_points = 20}).truncated);
}

TEST_F(NearMapTest, NothingNearIsNoError) {
  EXPECT_THAT(FindNearMap(map_, {0, 0, 0}, {}).own_points, IsEmpty());
  Fill(2);
  const NearMap near = FindNearMap(map_, {500, 0, 0}, {});
  EXPECT_THAT(near.own_points, IsEmpty());
  EXPECT_THAT(near.keyframes, IsEmpty());
  EXPECT_FALSE(near.truncated);
}

TEST_F(NearMapTest, NothingIsLostBetweenPieces) {
  constexpr uint32_t kMany = 4500;
  Fill(kMany);
  const NearMap near = FindNearMap(map_, {0, 0, 0}, {.radius_m = 1e6, .max_keyframes = 100'000});
  EXPECT_EQ(near.own_points.size(), kMany);
  EXPECT_EQ(near.shared_points.size(), kMany);
  EXPECT_EQ(near.keyframes.size(), 2 * kMany);
}

}  // namespace
}  // namespace corbslam::client_agent
