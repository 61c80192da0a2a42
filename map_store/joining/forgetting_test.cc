#include "map_store/joining/forgetting.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "map_store/ingest/gone_local_maps.h"
#include "map_store/joining/joining_choice.h"
#include "map_store/records/record_application.h"
#include "map_store/records/state_validation.h"
#include "map_store/testing/many_starts.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

using ::testing::ElementsAre;
using testing::MakeManyStarts;

TEST(ForgettingTest, ChoosesByNumberOrAge) {
  MissionState state = MakeManyStarts(4);
  state.FindLocalMap({2})->frames.back().timestamp_ns = 5000;
  ForgetRequest request{.agent = "r", .before_ns = {}, .keep = 1};
  auto chosen = ChooseForgotten(request, state);
  ASSERT_TRUE(chosen.ok());
  EXPECT_THAT(chosen->local_maps, ElementsAre(LocalMapId{1}, LocalMapId{2}, LocalMapId{3}));
  EXPECT_THAT(chosen->numbers, ElementsAre(1, 2, 3));
  EXPECT_EQ(chosen->keyframes, 9u);
  request = {.agent = "r", .before_ns = 2000, .keep = {}};
  chosen = ChooseForgotten(request, state);
  EXPECT_THAT(chosen->local_maps, ElementsAre(LocalMapId{1}, LocalMapId{3}, LocalMapId{4}));
  state.FindLocalMap({4})->closed = false;
  chosen = ChooseForgotten(request, state);
  EXPECT_THAT(chosen->local_maps, ElementsAre(LocalMapId{1}, LocalMapId{3}));
  request.keep = 1;
  EXPECT_TRUE(absl::IsInvalidArgument(ChooseForgotten(request, state).status()));
  request = {.agent = "nobody", .before_ns = {}, .keep = 1};
  EXPECT_TRUE(absl::IsNotFound(ChooseForgotten(request, state).status()));
}

TEST(ForgettingTest, OthersStandWhereTheyStood) {
  MissionState state = MakeManyStarts(4);
  state.global.landmarks.Merge({{1}, 0}, {{4}, 0});
  const IslandPoses before = ComputePoses(*state.FindLocalMap({4}), state.global);
  const ForgetRecord record{{{1}, {2}}};
  ASSERT_TRUE(CheckReplay(record, state).ok());
  Apply(record, state);
  EXPECT_EQ(state.local_maps.size(), 2u);
  EXPECT_EQ(state.FindKeyframe({{1}, 0}), nullptr);
  EXPECT_EQ(ComputePoses(*state.FindLocalMap({4}), state.global).size(), before.size());
  EXPECT_EQ(ResolvePoint(state, {{1}, 0}), (MapPointId{{4}, 0})) << "it has an heir";
  EXPECT_FALSE(ResolvePoint(state, {{1}, 1}).IsValid());
  EXPECT_EQ(state.ReferenceIsland(), LocalMapId{1}) << "the global frame stays";
  EXPECT_TRUE(ValidateState(state).ok()) << ValidateState(state);
  EXPECT_TRUE(absl::IsFailedPrecondition(CheckTakesBatches(state, {1})));
  EXPECT_EQ(LastBatchOf(state, {1}), 11u);
  EXPECT_TRUE(absl::IsDataLoss(CheckReplay(record, state))) << "they are gone";
}

TEST(ForgettingTest, WhatBecameOneGoesAsOne) {
  MissionState state = MakeManyStarts(4);
  while (const auto joining = ChooseJoining(state, 1)) ApplyJoining(*joining, state);
  const auto chosen = ChooseForgotten({.agent = "r", .before_ns = {}, .keep = 1}, state);
  ASSERT_TRUE(chosen.ok());
  EXPECT_THAT(chosen->local_maps, ElementsAre(LocalMapId{1}));
  EXPECT_EQ(chosen->parts, 2u);
  EXPECT_THAT(chosen->numbers, ElementsAre(1, 2, 3)) << "of its parts, too";
  ForgetLocalMaps(chosen->local_maps, state);
  EXPECT_EQ(state.FindLocalMap({2}), nullptr);
  EXPECT_TRUE(state.joined_into.empty());
  EXPECT_EQ(LastBatchOf(state, {3}), 13u);
  EXPECT_TRUE(ValidateState(state).ok()) << ValidateState(state);
}

TEST(ForgettingTest, AMissionMayBecomeEmpty) {
  MissionState state = MakeManyStarts(2);
  ForgetLocalMaps({{1}, {2}}, state);
  EXPECT_TRUE(state.local_maps.empty());
  EXPECT_TRUE(state.global.islands.empty());
  EXPECT_TRUE(state.agents.at("r").local_maps.empty());
  EXPECT_TRUE(ValidateState(state).ok()) << ValidateState(state);
}

}  // namespace
}  // namespace corbslam::map_store
