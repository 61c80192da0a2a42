#include "client_agent/far/far_share.h"

#include <gtest/gtest.h>

#include "client_agent/far/testing/spooled_row.h"

namespace corbslam::client_agent {
namespace {

constexpr LocalMapId kMap{21};

class FarShareTest : public ::testing::Test {
 protected:
  FarShareTest() {
    SpooledRow(kMap, 6).Fill(
        [](const std::vector<Descriptor>&) { return std::shared_ptr<const Words>(); }, map_);
  }
  static std::vector<KeyframeId> Ids(uint32_t first, uint32_t last) {
    std::vector<KeyframeId> ids;
    for (uint32_t i = first; i <= last; ++i) ids.push_back({kMap, i});
    return ids;
  }

  Map map_;
  FarShare share_;
};

TEST_F(FarShareTest, KeyframesComeWithThePointsThatTheySee) {
  const SharedUpdate update = share_.Bring(map_, Ids(1, 2));
  ASSERT_EQ(update.keyframes.size(), 2u);
  EXPECT_TRUE(update.apart) << "the frame is no mission's";
  ASSERT_TRUE(update.global_from_local.has_value());
  EXPECT_TRUE(update.global_from_local->ToRigid().translation.isZero(0));
  // Each keyframe sees two points, the second of which the next one sees, too.
  EXPECT_EQ(update.points.size(), 3u);
  EXPECT_EQ(update.keyframes[0].points[1], update.keyframes[1].points[0]);
  EXPECT_EQ(update.keyframes[0].parent, (KeyframeId{kMap, 0}));
  EXPECT_EQ(CameraCentre(update.keyframes[1].camera_from_global.ToRigid()),
            Eigen::Vector3d(2, 0, 0));
}

TEST_F(FarShareTest, NothingIsToldTwice) {
  share_.Bring(map_, Ids(1, 2));
  const SharedUpdate update = share_.Bring(map_, Ids(1, 3));
  EXPECT_EQ(update.keyframes.size(), 1u);
  EXPECT_EQ(update.points.size(), 1u);
  EXPECT_FALSE(update.global_from_local.has_value());
}

TEST_F(FarShareTest, PointsGoWithTheLastKeyframeThatSeesThem) {
  share_.Bring(map_, Ids(1, 3));
  const SharedUpdate first = share_.TakeOut(Ids(1, 1));
  EXPECT_EQ(first.removed_keyframes, Ids(1, 1));
  EXPECT_EQ(first.removed_points, (std::vector<MapPointId>{{kMap, 1}}));
  const SharedUpdate rest = share_.TakeOut(Ids(0, 5));
  EXPECT_EQ(rest.removed_keyframes, Ids(2, 3));
  EXPECT_EQ(rest.removed_points.size(), 3u);
  EXPECT_TRUE(share_.told().empty());
}

TEST_F(FarShareTest, AnotherLocalMapWasToldNothing) {
  share_.Bring(map_, Ids(1, 3));
  share_.Restart();
  const SharedUpdate update = share_.Bring(map_, Ids(1, 3));
  EXPECT_EQ(update.keyframes.size(), 3u);
  EXPECT_TRUE(update.global_from_local.has_value());
}

}  // namespace
}  // namespace corbslam::client_agent
