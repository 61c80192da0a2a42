#include "slam/evaluation/trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam {
namespace {

StampedPose At(int64_t timestamp_ns, double x) {
  StampedPose pose;
  pose.timestamp_ns = timestamp_ns;
  pose.world_from_camera.translation.x() = x;
  return pose;
}

TEST(AssociateByTimeTest, TakesTheNearestWithinTheGap) {
  const Trajectory truth = {At(0, 0), At(100, 1), At(200, 2)};
  const std::vector<PosePair> pairs =
      AssociateByTime({At(40, 0), At(60, 0), At(199, 0), At(260, 0)}, truth, 50);
  ASSERT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[0].truth.timestamp_ns, 0);
  EXPECT_EQ(pairs[1].truth.timestamp_ns, 100);
  EXPECT_EQ(pairs[2].truth.timestamp_ns, 200);
}

TEST(AssociateByTimeTest, WorksBackwards) {
  const Trajectory truth = {At(0, 0), At(100, 1)};
  const std::vector<PosePair> pairs = AssociateByTime({At(101, 0), At(-1, 0)}, truth, 50);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].truth.timestamp_ns, 100);
  EXPECT_EQ(pairs[1].truth.timestamp_ns, 0);
}

TEST(AssociateByTimeTest, FindsNothingInAnEmptyTruth) {
  EXPECT_TRUE(AssociateByTime({At(0, 0)}, {}).empty());
}

TEST(AssociateByTimeTest, UsesATruePoseOnceAndNearestFirst) {
  const Trajectory truth = {At(0, 0), At(100, 1), At(200, 2)};
  // Two want the one at 100: the second is nearer, the first takes what is left within the gap.
  std::vector<PosePair> pairs = AssociateByTime({At(70, 0), At(110, 0)}, truth, 80);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].truth.timestamp_ns, 0);
  EXPECT_EQ(pairs[1].truth.timestamp_ns, 100);
  pairs = AssociateByTime({At(70, 0), At(110, 0)}, truth, 40);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].estimate.timestamp_ns, 110);
  // More estimates than true poses, some of the same time.
  pairs = AssociateByTime({At(100, 0), At(100, 1), At(100, 2), At(100, 3)}, truth, 1000);
  EXPECT_EQ(pairs.size(), 3u);
  EXPECT_EQ(pairs[0].truth.timestamp_ns, 100);
}

TEST(AssociateByTimeTest, OfTwoEquallyNearTakesTheEarlier) {
  const std::vector<PosePair> pairs = AssociateByTime({At(50, 0)}, {At(0, 0), At(100, 1)}, 50);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_EQ(pairs[0].truth.timestamp_ns, 0);
}

TEST(MergeByTimeTest, SortsAndLetsTheFirstWin) {
  const Trajectory merged = MergeByTime({{At(3, 1), At(5, 1)}, {At(1, 2), At(3, 2)}});
  ASSERT_EQ(merged.size(), 3u);
  EXPECT_EQ(merged[0].world_from_camera.translation.x(), 2);
  EXPECT_EQ(merged[1].world_from_camera.translation.x(), 1);
  EXPECT_EQ(merged[2].world_from_camera.translation.x(), 1);
}

TEST(KeepFromTest, KeepsWhatIsNotEarlier) {
  const Trajectory kept = KeepFrom({At(1, 0), At(2, 0), At(3, 0)}, 2);
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[0].timestamp_ns, 2);
}

TEST(PathLengthTest, AddsTheSteps) {
  EXPECT_DOUBLE_EQ(PathLength_m({At(0, 0), At(1, 3), At(2, 1)}), 5);
  EXPECT_DOUBLE_EQ(PathLength_m({}), 0);
}

}  // namespace
}  // namespace corbslam
