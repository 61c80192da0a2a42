#include "map_store/fusion/fusion_policy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Kind = FusionAction::Kind;

constexpr IslandId kFirst = {1};
constexpr IslandId kSecond = {2};
constexpr IslandId kThird = {3};

FusionSummary::IslandSummary MakeIsland(IslandId id, size_t order, size_t keyframes) {
  FusionSummary::IslandSummary island;
  island.id = id;
  island.order = order;
  island.keyframes = keyframes;
  return island;
}

// The second island is the largest, the first is the reference island.
FusionSummary MakeSummary() {
  FusionSummary summary;
  summary.islands = {MakeIsland(kFirst, 0, 10), MakeIsland(kSecond, 1, 30),
                     MakeIsland(kThird, 2, 20)};
  return summary;
}

TEST(FusionPolicyTest, NothingToDo) { EXPECT_THAT(DecideActions(MakeSummary(), {}), IsEmpty()); }

TEST(FusionPolicyTest, QueriesRunWhenTheGraphLaneIsFree) {
  FusionSummary summary = MakeSummary();
  summary.queries = 3;
  EXPECT_THAT(DecideActions(summary, {}), ElementsAre(FusionAction{Kind::kQuery, {}, {}, {}}));
  summary.graph_lane_busy = true;
  EXPECT_THAT(DecideActions(summary, {}), IsEmpty());
}

TEST(FusionPolicyTest, AnIslandInMetresKeepsItsFrameBeforeAll) {
  FusionSummary summary = MakeSummary();
  summary.islands[0].in_metres = false;
  summary.islands[1].in_metres = false;
  summary.waiting = {{7, kFirst, kThird, false}};
  EXPECT_THAT(DecideActions(summary, {}),
              ElementsAre(FusionAction{Kind::kFuse, kThird, kFirst, {7}}));
  summary.waiting = {{7, kSecond, kFirst, false}};
  EXPECT_THAT(DecideActions(summary, {}),
              ElementsAre(FusionAction{Kind::kFuse, kFirst, kSecond, {7}}))
      << "of two without metres the reference island keeps its frame";
}

TEST(FusionPolicyTest, TheReferenceIslandKeepsItsFrameElseTheLarger) {
  FusionSummary summary = MakeSummary();
  summary.queries = 3;
  summary.waiting = {{7, kSecond, kFirst, false}};
  EXPECT_THAT(DecideActions(summary, {}),
              ElementsAre(FusionAction{Kind::kFuse, kFirst, kSecond, {7}}));
  summary.waiting = {{7, kThird, kSecond, false}};
  EXPECT_THAT(DecideActions(summary, {}),
              ElementsAre(FusionAction{Kind::kFuse, kSecond, kThird, {7}}));
  summary.islands[2].keyframes = 30;
  EXPECT_THAT(DecideActions(summary, {}),
              ElementsAre(FusionAction{Kind::kFuse, kSecond, kThird, {7}}))
      << "the earlier of equals";
}

constexpr FusionSummary::OverlapSummary Vague(uint64_t id) {
  return {id, kFirst, kSecond, /*urgent=*/false, /*alone=*/false, /*vague=*/true};
}

TEST(FusionPolicyTest, AVagueOverlapWaitsForABetterOne) {
  FusionSummary summary = MakeSummary();
  summary.waiting = {Vague(7)};
  EXPECT_THAT(DecideActions(summary, {}), IsEmpty());
  summary.waiting.push_back({8, kSecond, kFirst, false});
  EXPECT_THAT(DecideActions(summary, {}),
              ElementsAre(FusionAction{Kind::kFuse, kFirst, kSecond, {7, 8}}));
}

TEST(FusionPolicyTest, ThreeVagueOverlapsAreEnough) {
  FusionSummary summary = MakeSummary();
  summary.waiting = {Vague(7), Vague(8)};
  EXPECT_THAT(DecideActions(summary, {}), IsEmpty());
  summary.waiting.push_back(Vague(9));
  EXPECT_THAT(DecideActions(summary, {}),
              ElementsAre(FusionAction{Kind::kFuse, kFirst, kSecond, {7, 8, 9}}));
}

TEST(FusionPolicyTest, AVagueOverlapIsBetterThanNoneOnceAllRobotsHaveLeft) {
  FusionSummary summary = MakeSummary();
  summary.waiting = {Vague(7)};
  summary.islands[0].quiet = true;
  EXPECT_THAT(DecideActions(summary, {}), IsEmpty()) << "a robot drives in the other one";
  summary.islands[1].quiet = true;
  summary.queries = 1;
  EXPECT_THAT(DecideActions(summary, {}), ElementsAre(FusionAction{Kind::kQuery, {}, {}, {}}))
      << "the next answer may be a better one";
  summary.queries = 0;
  EXPECT_THAT(DecideActions(summary, {}),
              ElementsAre(FusionAction{Kind::kFuse, kFirst, kSecond, {7}}));
}

TEST(FusionPolicyTest, WhatWaitsForABetterOverlapKeepsNoIslandFromItsAdjustment) {
  FusionSummary summary = MakeSummary();
  summary.waiting = {Vague(7)};
  summary.islands[0].fused = true;
  summary.islands[0].needs_adjustment = true;
  EXPECT_THAT(DecideActions(summary, {}), ElementsAre(FusionAction{Kind::kAdjust, kFirst, {}, {}}));
}

TEST(FusionPolicyTest, AllOverlapsOfAPairGoIntoOneFusing) {
  FusionSummary summary = MakeSummary();
  summary.waiting = {
      {1, kFirst, kSecond, false}, {2, kThird, kSecond, false}, {3, kSecond, kFirst, false}};
  EXPECT_THAT(DecideActions(summary, {}),
              ElementsAre(FusionAction{Kind::kFuse, kFirst, kSecond, {1, 3}}));
}

TEST(FusionPolicyTest, OverlapsInsideAnIslandWaitForEachOther) {
  FusionSummary summary = MakeSummary();
  summary.queries = 1;
  const FusionAction query{Kind::kQuery, {}, {}, {}};
  summary.waiting = {{1, kFirst, kFirst, false}, {2, kFirst, kFirst, false}};
  EXPECT_THAT(DecideActions(summary, {.weld_every = 3}), ElementsAre(query));
  summary.waiting.push_back({4, kFirst, kFirst, false});
  EXPECT_THAT(DecideActions(summary, {.weld_every = 3}),
              ElementsAre(FusionAction{Kind::kWeld, kFirst, {}, {1, 2, 4}}));
}

TEST(FusionPolicyTest, OfALargeIslandMoreOverlapsWaitForEachOther) {
  FusionSummary summary = MakeSummary();
  summary.islands[0].keyframes = 500;
  for (uint64_t id = 1; id <= 4; ++id) summary.waiting.push_back({id, kFirst, kFirst, false});
  EXPECT_THAT(DecideActions(summary, {}), IsEmpty());
  summary.waiting.push_back({5, kFirst, kFirst, false});
  EXPECT_THAT(DecideActions(summary, {}),
              ElementsAre(FusionAction{Kind::kWeld, kFirst, {}, {1, 2, 3, 4, 5}}));
  // All that is welded costs as many keyframes as the island has, times a constant, however large
  // it becomes.
  size_t seen = 0;
  size_t welded_at = 0;
  for (size_t keyframes = 100; keyframes <= 100'000; ++keyframes) {
    const size_t waiting = (keyframes - welded_at) / 3;
    summary.islands[0].keyframes = keyframes;
    summary.waiting.assign(waiting, {1, kFirst, kFirst, false});
    if (DecideActions(summary, {}).empty()) continue;
    seen += keyframes;
    welded_at = keyframes;
  }
  EXPECT_LT(seen, 50u * 100'000u);
}

TEST(FusionPolicyTest, AnUrgentOneOrTheEndOfTheStreamsOrALocalLoopDoesNotWait) {
  FusionSummary urgent = MakeSummary();
  urgent.waiting = {{1, kFirst, kFirst, true}};
  EXPECT_THAT(DecideActions(urgent, {}), ElementsAre(FusionAction{Kind::kWeld, kFirst, {}, {1}}));
  FusionSummary last = MakeSummary();
  last.waiting = {{1, kFirst, kFirst, false}};
  EXPECT_THAT(DecideActions(last, {}), IsEmpty());
  last.islands[0].quiet = true;
  EXPECT_THAT(DecideActions(last, {}), ElementsAre(FusionAction{Kind::kWeld, kFirst, {}, {1}}));
  FusionSummary loop = MakeSummary();
  loop.islands[0].relaxed = 1;
  EXPECT_THAT(DecideActions(loop, {}), ElementsAre(FusionAction{Kind::kWeld, kFirst, {}, {}}));
}

TEST(FusionPolicyTest, OverlapsThatWereRefusedTogetherAreTriedOneByOne) {
  FusionSummary weld = MakeSummary();
  weld.waiting = {{1, kFirst, kFirst, false, true}, {2, kFirst, kFirst, false, true}};
  EXPECT_THAT(DecideActions(weld, {}), ElementsAre(FusionAction{Kind::kWeld, kFirst, {}, {1}}));
  // Overlaps that need not be alone go first, together, when one of them stands first.
  weld.waiting = {
      {1, kFirst, kFirst, false}, {2, kFirst, kFirst, false, true}, {3, kFirst, kFirst, false}};
  EXPECT_THAT(DecideActions(weld, {}), ElementsAre(FusionAction{Kind::kWeld, kFirst, {}, {1, 3}}));
  FusionSummary fuse = MakeSummary();
  fuse.waiting = {{1, kFirst, kSecond, false, true}, {2, kFirst, kSecond, false, true}};
  EXPECT_THAT(DecideActions(fuse, {}),
              ElementsAre(FusionAction{Kind::kFuse, kFirst, kSecond, {1}}));
}

TEST(FusionPolicyTest, AdjustmentFollowsFusingAndRunsBesideQueries) {
  FusionSummary summary = MakeSummary();
  summary.islands[0].fused = true;
  summary.islands[0].needs_adjustment = true;
  summary.queries = 5;
  const FusionAction query{Kind::kQuery, {}, {}, {}};
  const FusionAction adjust{Kind::kAdjust, kFirst, {}, {}};
  EXPECT_THAT(DecideActions(summary, {}), ElementsAre(query, adjust));
  summary.adjustment_lane_busy = true;
  EXPECT_THAT(DecideActions(summary, {}), ElementsAre(query));
}

TEST(FusionPolicyTest, AdjustmentWaitsForFusingThatWouldUndoIt) {
  FusionSummary summary = MakeSummary();
  summary.islands[0].fused = true;
  summary.islands[0].needs_adjustment = true;
  summary.waiting = {{9, kFirst, kSecond, false}};
  summary.graph_lane_busy = true;
  EXPECT_THAT(DecideActions(summary, {}), IsEmpty());
}

struct CancelCase {
  bool adjusting;
  size_t cancelled;
  bool welds;
};

TEST(FusionPolicyTest, AnAdjustmentIsCancelledTwiceInARowThenLetEnd) {
  const std::vector<CancelCase> cases = {
      {true, 0, true}, {true, 1, true}, {true, 2, false}, {true, 3, false}, {false, 2, true}};
  const FusionAction query{Kind::kQuery, {}, {}, {}};
  const FusionAction weld{Kind::kWeld, kFirst, {}, {1}};
  for (const CancelCase& one : cases) {
    FusionSummary summary = MakeSummary();
    summary.queries = 1;
    summary.waiting = {{1, kFirst, kFirst, true}};
    summary.adjustment_lane_busy = true;
    summary.islands[0].adjusting = one.adjusting;
    summary.islands[0].cancelled_adjustments = one.cancelled;
    EXPECT_THAT(DecideActions(summary, {}), ElementsAre(one.welds ? weld : query))
        << one.adjusting << one.cancelled;
  }
}

TEST(FusionPolicyTest, AnIslandIsFusedAlsoWhileItsAdjustmentIsLetEnd) {
  FusionSummary summary = MakeSummary();
  summary.waiting = {{1, kFirst, kFirst, true}, {2, kFirst, kSecond, false}};
  summary.adjustment_lane_busy = true;
  summary.islands[0].adjusting = true;
  summary.islands[0].cancelled_adjustments = 2;
  EXPECT_THAT(DecideActions(summary, {}),
              ElementsAre(FusionAction{Kind::kFuse, kFirst, kSecond, {2}}));
}

TEST(FusionPolicyTest, AdjustmentWaitsForALocalLoopsWelding) {
  FusionSummary summary = MakeSummary();
  summary.islands[0].fused = true;
  summary.islands[0].needs_adjustment = true;
  summary.islands[0].relaxed = 1;
  summary.graph_lane_busy = true;
  EXPECT_THAT(DecideActions(summary, {}), IsEmpty());
}

TEST(FusionPolicyTest, LoneMapsAreNotAdjusted) {
  FusionSummary summary = MakeSummary();
  summary.islands[0].dirty = true;
  summary.islands[0].quiet = true;
  EXPECT_THAT(DecideActions(summary, {}), IsEmpty());
}

struct AdjustCase {
  size_t keyframes;
  size_t overlaps;
  size_t new_keyframes;
  size_t displaced;
  size_t moved;
  bool adjusts;
};

TEST(FusionPolicyTest, AnAdjustmentIsDueWhenEnoughHasChanged) {
  const std::vector<AdjustCase> cases = {
      // Of a small island at least 20 keyframes have to change.
      {50, 0, 0, 19, 0, false},
      {50, 0, 0, 20, 0, true},
      {50, 0, 0, 0, 20, true},
      {50, 0, 0, 10, 10, true},
      // Of a large one a fifth has to change.
      {1000, 0, 0, 199, 0, false},
      {1000, 0, 0, 200, 0, true},
      {1000, 0, 0, 0, 199, false},
      {1000, 0, 0, 0, 200, true},
      {1000, 1, 100, 50, 50, true},
      // Overlaps that confirm what is known move nothing.
      {50, 100, 0, 0, 0, false},
      // New keyframes follow the ones before them until an overlap says more.
      {1000, 0, 900, 0, 0, false},
      {1000, 1, 199, 0, 0, false},
      {1000, 1, 200, 0, 0, true},
      {50, 3, 19, 0, 0, false},
      {50, 3, 20, 0, 0, true},
      {0, 0, 0, 0, 0, false},
  };
  for (const AdjustCase& one : cases) {
    FusionSummary summary = MakeSummary();
    FusionSummary::IslandSummary& island = summary.islands[0];
    island.fused = true;
    island.dirty = true;
    island.keyframes = one.keyframes;
    island.overlaps_since_adjustment = one.overlaps;
    island.new_keyframes = one.new_keyframes;
    island.displaced = one.displaced;
    island.moved = one.moved;
    summary.graph_lane_busy = true;
    const auto actions = DecideActions(summary, {.adjust_share = 0.2, .adjust_min_keyframes = 20});
    EXPECT_EQ(actions.size(), one.adjusts ? 1u : 0u)
        << one.keyframes << " " << one.overlaps << " " << one.new_keyframes << " " << one.displaced
        << " " << one.moved;
  }
}

// In a mission that only grows, all its adjustments together are of a bounded number of keyframes
// for each keyframe.
TEST(FusionPolicyTest, AllAdjustmentsOfAGrowingIslandCostAsItsKeyframes) {
  const PolicyLimits limits = {.adjust_share = 0.2, .adjust_min_keyframes = 20};
  FusionSummary summary = MakeSummary();
  FusionSummary::IslandSummary& island = summary.islands[0];
  island.fused = true;
  summary.graph_lane_busy = true;
  size_t adjusted = 0;
  size_t adjustments = 0;
  size_t cost = 0;
  constexpr size_t kKeyframes = 20000;
  for (island.keyframes = 1; island.keyframes <= kKeyframes; ++island.keyframes) {
    island.overlaps_since_adjustment = 5;
    island.new_keyframes = island.keyframes - adjusted;
    if (DecideActions(summary, limits).empty()) continue;
    adjusted = island.keyframes;
    cost += adjusted;
    ++adjustments;
  }
  EXPECT_GT(adjustments, 10u);
  EXPECT_LE(cost, kKeyframes * 5);
}

struct QuietCase {
  bool dirty;
  bool quiet;
  size_t queries;
  bool adjusts;
};

TEST(FusionPolicyTest, TheLastAdjustmentComesWhenNobodyStreamsAndNothingIsLeftToAsk) {
  const std::vector<QuietCase> cases = {{true, true, 0, true},
                                        {false, true, 0, false},
                                        {true, false, 0, false},
                                        {true, true, 1, false}};
  for (const QuietCase& one : cases) {
    FusionSummary summary = MakeSummary();
    summary.islands[0].fused = true;
    summary.islands[0].dirty = one.dirty;
    summary.islands[0].quiet = one.quiet;
    summary.queries = one.queries;
    summary.graph_lane_busy = true;
    EXPECT_EQ(DecideActions(summary, {}).size(), one.adjusts ? 1u : 0u)
        << one.dirty << one.quiet << one.queries;
  }
}

}  // namespace
}  // namespace corbslam::map_store
