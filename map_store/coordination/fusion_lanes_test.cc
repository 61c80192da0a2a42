#include "map_store/coordination/fusion_lanes.h"

#include <gtest/gtest.h>

namespace corbslam::map_store {
namespace {

using Kind = FusionAction::Kind;

constexpr IslandId kIsland{1};
constexpr IslandId kOther{2};

FusionAction Action(Kind kind, IslandId target) {
  FusionAction action;
  action.kind = kind;
  action.target = target;
  return action;
}

TEST(FusionLanesTest, ALaneIsBusyUntilItIsReleased) {
  FusionLanes lanes;
  EXPECT_FALSE(lanes.Running(FusionLane::kGraph).has_value());
  const CancelFlag cancelled = lanes.Claim(Action(Kind::kWeld, kIsland));
  EXPECT_FALSE(cancelled->load());
  EXPECT_EQ(lanes.Running(FusionLane::kGraph), Kind::kWeld);
  EXPECT_FALSE(lanes.IsBusy(FusionLane::kAdjustment));
  lanes.CancelAll();
  EXPECT_TRUE(cancelled->load());
  EXPECT_TRUE(lanes.IsBusy(FusionLane::kGraph));
  lanes.Release(FusionLane::kGraph);
  EXPECT_FALSE(lanes.IsBusy(FusionLane::kGraph));
}

TEST(FusionLanesTest, AnAdjustmentEndsOnceWhenItsIslandChanges) {
  FusionLanes lanes;
  lanes.CancelAdjustment(Action(Kind::kWeld, kIsland));  // No adjustment runs.
  const CancelFlag cancelled = lanes.Claim(Action(Kind::kAdjust, kIsland));
  EXPECT_TRUE(lanes.IsAdjusting(kIsland));
  EXPECT_FALSE(lanes.IsAdjusting(kOther));
  lanes.CancelAdjustment(Action(Kind::kWeld, kOther));
  EXPECT_FALSE(cancelled->load());
  FusionAction merge = Action(Kind::kFuse, kOther);
  merge.source = kIsland;
  lanes.CancelAdjustment(merge);
  lanes.CancelAdjustment(merge);
  EXPECT_TRUE(cancelled->load());
  EXPECT_FALSE(lanes.IsAdjusting(kIsland));
  EXPECT_EQ(lanes.CountCancelled(kOther), 1u);
  EXPECT_EQ(lanes.CountCancelled(kIsland), 0u);
}

TEST(FusionLanesTest, TroubleIsForgottenByIsland) {
  FusionLanes lanes;
  EXPECT_EQ(lanes.NoteFailedAdjustment(kIsland), 1);
  EXPECT_EQ(lanes.NoteFailedAdjustment(kIsland), 2);
  EXPECT_EQ(lanes.NoteFailedAdjustment(kOther), 1);
  lanes.ForgetTrouble(kIsland);
  EXPECT_EQ(lanes.NoteFailedAdjustment(kIsland), 1);
  EXPECT_EQ(lanes.NoteFailedAdjustment(kOther), 2);
  lanes.ForgetTrouble();
  EXPECT_EQ(lanes.NoteFailedAdjustment(kOther), 1);
}

}  // namespace
}  // namespace corbslam::map_store
