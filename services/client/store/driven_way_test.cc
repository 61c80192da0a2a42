#include "services/client/store/driven_way.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace corbslam::services {
namespace {

// 60 m ahead, then 60 m to the right, a keyframe each two metres.
Rigid3d OnTheWay(uint32_t index) {
  const double way = 2.0 * index;
  Rigid3d pose;
  pose.translation = way < 60 ? Eigen::Vector3d(0, 0, way) : Eigen::Vector3d(way - 60, 0, 60);
  const double yaw = way < 60 ? 0 : M_PI / 2;
  pose.rotation = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY());
  return pose;
}

TEST(UsualStepTest, StaysAsItWasWhereMostKeyframesWent) {
  std::map<KeyframeId, Rigid3d> all;
  std::map<KeyframeId, Rigid3d> left;
  for (uint32_t i = 0; i < 60; ++i) {
    all[{LocalMapId{7}, i}] = OnTheWay(i);
    if (i < 3 || i % 17 == 0) left[{LocalMapId{7}, i}] = OnTheWay(i);
  }
  EXPECT_NEAR(UsualStep(all), 2, 1e-9);
  EXPECT_NEAR(UsualStep(left), 2, 0.1);
  EXPECT_EQ(UsualStep({}), 0);
}

TEST(UsualStepTest, DoesNotStepFromOneLocalMapIntoAnother) {
  const std::map<KeyframeId, Rigid3d> two = {{{LocalMapId{1}, 0}, OnTheWay(0)},
                                             {{LocalMapId{1}, 1}, OnTheWay(1)},
                                             {{LocalMapId{2}, 0}, OnTheWay(50)}};
  EXPECT_NEAR(UsualStep(two), 2, 1e-9);
}

TEST(IsGapTest, DoesNotCutCorners) {
  EXPECT_FALSE(IsGap(OnTheWay(29), OnTheWay(31), 2)) << "the robot's own keyframes";
  EXPECT_FALSE(IsGap(OnTheWay(3), OnTheWay(12), 2)) << "straight on";
  EXPECT_TRUE(IsGap(OnTheWay(25), OnTheWay(35), 2)) << "around the corner";
  EXPECT_TRUE(IsGap(OnTheWay(0), OnTheWay(29), 2)) << "so far that nobody knows";
  EXPECT_FALSE(IsGap(OnTheWay(0), OnTheWay(29), 0));
}

TEST(PiecesOfTest, AreCutWhereTheRobotWasLostAndWhereAnotherMapBegins) {
  ServedTrajectory served(6);
  for (size_t i = 0; i < served.size(); ++i) {
    served[i].local_map = i < 4 ? "1" : "2";
    served[i].island = i < 5 ? "1" : "2";
    served[i].after_gap = i == 2;
  }
  const DrivenPath pieces = PiecesOf(served);
  ASSERT_EQ(pieces.size(), 4u);
  EXPECT_EQ(pieces[0].size(), 2u);
  EXPECT_EQ(pieces[1].size(), 2u);
  EXPECT_TRUE(PiecesOf({}).empty());
}

}  // namespace
}  // namespace corbslam::services
