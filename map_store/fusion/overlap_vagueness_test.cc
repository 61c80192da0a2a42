#include "map_store/fusion/overlap_vagueness.h"

#include <gtest/gtest.h>

#include "slam/optimisation/testing/synthetic_scene.h"

namespace corbslam::map_store {
namespace {

constexpr KeyframeId kCandidate = {LocalMapId{5}, 0};

// A scene whose points are 2 to 4 m away.
Map MakeScene() {
  corbslam::testing::SyntheticSceneOptions options;
  options.local_map = kCandidate.local_map;
  options.nearest_m = 2;
  options.farthest_m = 4;
  return corbslam::testing::MakeSyntheticScene(options).map;
}

Overlap MakeOverlap(double position_sigma_m, double rotation_sigma_rad) {
  Overlap overlap;
  overlap.candidate = kCandidate;
  overlap.covariance.diagonal().head<3>().setConstant(position_sigma_m * position_sigma_m);
  overlap.covariance.diagonal().segment<3>(3).setConstant(rotation_sigma_rad * rotation_sigma_rad);
  return overlap;
}

TEST(OverlapVaguenessTest, AHundredthOfTheDistanceIsTooMuch) {
  const Map map = MakeScene();
  EXPECT_FALSE(IsVague(MakeOverlap(0.019, 0), map));
  EXPECT_TRUE(IsVague(MakeOverlap(0.041, 0), map));
}

TEST(OverlapVaguenessTest, ATurnMovesACameraThatIsFarAway) {
  const Map map = MakeScene();
  Overlap overlap = MakeOverlap(0.001, 0.002);
  EXPECT_FALSE(IsVague(overlap, map));
  overlap.candidate_from_query.translation = {0, 0, -30};
  EXPECT_TRUE(IsVague(overlap, map));
}

TEST(OverlapVaguenessTest, WhatIsNotKnownIsNotVague) {
  const Map map = MakeScene();
  EXPECT_FALSE(IsVague(MakeOverlap(0, 0), map));
  EXPECT_FALSE(IsVague(MakeOverlap(1, 1), Map()));
}

}  // namespace
}  // namespace corbslam::map_store
