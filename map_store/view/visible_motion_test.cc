#include "map_store/view/visible_motion.h"

#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

// Depths are well known up to 20 m.
Camera MakeCamera() {
  Camera camera = {500, 500, 320, 240, 640, 480, 0.5, 20};
  return camera;
}

Similarity3d At(double x_m, double turn_rad) {
  Similarity3d pose;
  pose.rotation = Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitY());
  pose.translation.x() = x_m;
  return pose;
}

TEST(VisibleMotionTest, APixelOfWhatIsCloseByIsSeen) {
  const Camera camera = MakeCamera();
  EXPECT_FALSE(IsSeenToMove(At(3, 0.2), At(3, 0.2), camera));
  EXPECT_FALSE(IsSeenToMove(At(3, 0.2), At(3.03, 0.2), camera)) << "0.8 px at 20 m";
  EXPECT_TRUE(IsSeenToMove(At(3, 0.2), At(3.05, 0.2), camera)) << "1.2 px at 20 m";
  EXPECT_FALSE(IsSeenToMove(At(0, 0.2), At(0, 0.2016), camera)) << "0.8 px";
  EXPECT_TRUE(IsSeenToMove(At(0, 0.2), At(0, 0.2024), camera)) << "1.2 px";
  Similarity3d larger = At(0, 0.2);
  larger.scale = 1.01;
  EXPECT_TRUE(IsSeenToMove(At(0, 0.2), larger, camera));
}

TEST(VisibleMotionTest, WhatIsFarMayMoveMore) {
  EXPECT_DOUBLE_EQ(LeastVisibleMotion({0, 0, 10}, MakeCamera()), 0.02);
  EXPECT_DOUBLE_EQ(LeastVisibleMotion({0, 0, 100}, MakeCamera()), 0.2);
}

}  // namespace
}  // namespace corbslam::map_store
