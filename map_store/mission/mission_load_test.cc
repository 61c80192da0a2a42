#include "map_store/mission/mission_load.h"

#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

constexpr IslandId kFirst = {1};
constexpr IslandId kSecond = {2};
constexpr IslandId kThird = {3};

FusionSummary::IslandSummary MakeIsland(IslandId id, size_t order) {
  FusionSummary::IslandSummary island;
  island.id = id;
  island.order = order;
  island.keyframes = 10;
  return island;
}

FusionSummary MakeSummary() {
  FusionSummary summary;
  summary.islands = {MakeIsland(kFirst, 0), MakeIsland(kSecond, 1), MakeIsland(kThird, 2)};
  return summary;
}

TEST(CountRequestsTest, NothingWaitsInAQuietMission) {
  EXPECT_EQ(CountRequests(MakeSummary(), {}), FusionRequestCounts());
}

TEST(CountRequestsTest, EachQueryIsARequest) {
  FusionSummary summary = MakeSummary();
  summary.queries = 7;
  EXPECT_EQ(CountRequests(summary, {}), (FusionRequestCounts{.verify = 7}));
}

TEST(CountRequestsTest, WhatRunsDoesNotHideTheRest) {
  FusionSummary summary = MakeSummary();
  summary.queries = 2;
  summary.graph_lane_busy = summary.adjustment_lane_busy = true;
  summary.waiting = {{7, kSecond, kFirst, false}};
  summary.islands[2].fused = summary.islands[2].needs_adjustment = true;
  EXPECT_EQ(CountRequests(summary, {}), (FusionRequestCounts{2, 1, 1}));
}

TEST(CountRequestsTest, APairOfIslandsIsFusedOnceHoweverManyOverlapsItHas) {
  FusionSummary summary = MakeSummary();
  summary.waiting = {
      {7, kSecond, kFirst, false}, {8, kFirst, kSecond, false}, {9, kThird, kFirst, false}};
  EXPECT_EQ(CountRequests(summary, {}), (FusionRequestCounts{.fuse = 2}));
  summary.waiting[0].alone = true;
  EXPECT_EQ(CountRequests(summary, {}), (FusionRequestCounts{.fuse = 3}))
      << "one that is to be asked about alone is a request of its own";
}

TEST(CountRequestsTest, ALoopOfTheOwnersIsOneRequest) {
  FusionSummary summary = MakeSummary();
  summary.islands[1].relaxed = 4;
  EXPECT_EQ(CountRequests(summary, {}), (FusionRequestCounts{.fuse = 1}));
}

TEST(CountRequestsTest, EachIslandThatIsDueIsAdjustedOnce) {
  FusionSummary summary = MakeSummary();
  for (FusionSummary::IslandSummary& island : summary.islands) {
    island.fused = true;
    island.displaced = 100;
    island.overlaps_since_adjustment = 50;
  }
  EXPECT_EQ(CountRequests(summary, {}), (FusionRequestCounts{.adjust = 3}));
}

}  // namespace
}  // namespace corbslam::map_store
