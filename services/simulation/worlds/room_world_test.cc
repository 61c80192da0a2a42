#include "services/simulation/worlds/room_world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

// Flies an eight of 4 x 2 m that rises and falls.
std::vector<Rigid3d> Eight() {
  std::vector<Rigid3d> poses;
  for (int i = 0; i < 600; ++i) {
    const double angle = 0.0105 * i;
    poses.push_back({Eigen::Quaterniond::Identity(),
                     {2 * std::sin(angle), -1.5 - 0.5 * std::sin(3 * angle), std::sin(2 * angle)}});
  }
  return poses;
}

TEST(RoomWorldTest, HoldsThePathAndNothingStandsInIt) {
  const std::vector<Rigid3d> poses = Eight();
  const Scene scene = BuildRoomScene(poses, 3);
  ASSERT_EQ(scene.meshes.size(), 1u);
  EXPECT_GT(scene.meshes[0].patches.size(), 300u);
  for (const Patch& patch : scene.meshes[0].patches) {
    Eigen::Vector3f low = patch.corners[0];
    Eigen::Vector3f high = patch.corners[0];
    for (const Eigen::Vector3f& corner : patch.corners) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
    for (const Rigid3d& pose : poses) {
      const Eigen::Vector3f at = pose.translation.cast<float>();
      EXPECT_GT((low - at).cwiseMax(at - high).maxCoeff(), 0.25F);
    }
  }
}

TEST(RoomWorldTest, SeedsGiveOtherRoomsAndEachTheSame) {
  const auto corner = [](uint64_t seed) {
    return BuildRoomScene(Eight(), seed).meshes[0].patches.back().corners[0];
  };
  EXPECT_EQ(corner(1), corner(1));
  EXPECT_NE(corner(1), corner(2));
}

}  // namespace
}  // namespace corbslam
