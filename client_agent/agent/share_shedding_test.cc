#include "client_agent/agent/share_shedding.h"

#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

SheddingLimits WithRadius(double radius_m) {
  SheddingLimits limits;
  limits.max_map_bytes = 1000;
  limits.radius_m = radius_m;
  return limits;
}

SheddingEvidence Evidence(double x, int seconds, uint64_t bytes, size_t own, size_t foreign) {
  return {bytes, own, foreign, {x, 0, 0}, seconds * int64_t{1'000'000'000}};
}

TEST(ShareSheddingTest, OthersGoBeforeTheMapIsFullAndOwnPartsAreNoReason) {
  ShareShedder shedder(WithRadius(40));
  EXPECT_FALSE(shedder.Judge(Evidence(0, 0, 400, 0, 10)).has_value()) << "it fits";
  EXPECT_FALSE(shedder.Judge(Evidence(0, 1, 1200, 20, 10)).has_value()) << "own parts fill it";
  EXPECT_EQ(shedder.Judge(Evidence(0, 2, 900, 4, 6)), 40);
}

TEST(ShareSheddingTest, ARobotThatOnlyLocalisesIsBounded) {
  ShareShedder shedder(WithRadius(40));
  EXPECT_EQ(shedder.Judge(Evidence(0, 0, 600, 0, 6)), 40);
  EXPECT_FALSE(shedder.Judge(Evidence(1, 1, 600, 0, 6)).has_value()) << "it is on its way";
  EXPECT_TRUE(shedder.IsUnderWay(1'000'000'000));
  EXPECT_EQ(shedder.Judge(Evidence(30, 10, 600, 0, 6)), 40) << "it has gone on";
}

TEST(ShareSheddingTest, WhereMoreIsNearThanFitsTheRadiusShrinksAndGrowsAgain) {
  ShareShedder shedder(WithRadius(9));
  EXPECT_EQ(shedder.Judge(Evidence(0, 0, 2000, 5, 50)), 9);
  EXPECT_EQ(shedder.Judge(Evidence(0, 10, 2000, 5, 50)), 6);
  EXPECT_EQ(shedder.Judge(Evidence(0, 20, 2000, 5, 50)), 5);
  EXPECT_FALSE(shedder.Judge(Evidence(0, 30, 2000, 5, 50)).has_value()) << "nothing helps here";
  EXPECT_FALSE(shedder.IsUnderWay(30'000'000'000)) << "own parts may go";
  EXPECT_EQ(shedder.Judge(Evidence(50, 40, 2000, 5, 50)), 6.25);
}

TEST(ShareSheddingTest, WithoutABoundNothingGoes) {
  ShareShedder shedder(SheddingLimits{});
  EXPECT_FALSE(shedder.Judge(Evidence(0, 0, 1 << 30, 0, 1000)).has_value());
}

}  // namespace
}  // namespace corbslam::client_agent
