// Tests that a robot is told where it lies in the mission's global frame as soon as that is known,
// once, and never before.
#include "map_store/sharing/global_place.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>

#include "map_store/testing/sharing_mission.h"

namespace corbslam::map_store {
namespace {

using testing::kMission;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TruthfulWorker;

class GlobalPlaceTest : public testing::SharingMission {
 protected:
  static void ExpectIdentity(const std::optional<Similarity3d>& place) {
    ASSERT_TRUE(place.has_value());
    EXPECT_EQ(place->scale, 1);
    EXPECT_EQ(place->translation.norm(), 0);
    EXPECT_NEAR(RotationAngle(place->rotation), 0, 1e-12);
  }
};

TEST_F(GlobalPlaceTest, TheFirstRobotAloneIsTheGlobalFrame) {
  TestAgent a(store_, kMission, "a", map_a_);
  ASSERT_TRUE(a.TakeShared().ok());
  EXPECT_FALSE(a.mirror().global_from_local.has_value()) << "no keyframe is stored yet";
  ASSERT_TRUE(a.Stream(1).ok());
  ASSERT_TRUE(a.TakeShared().ok());
  ExpectIdentity(a.mirror().global_from_local);
  EXPECT_EQ(a.mirror().updates, 1);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(a.TakeShared().ok());
  EXPECT_EQ(a.mirror().updates, 1) << "more keyframes cost nothing";
}

TEST_F(GlobalPlaceTest, ItsListenerHearsOfTheFirstKeyframeAndNoOther) {
  TestAgent a(store_, kMission, "a", map_a_);
  int calls = 0;
  store_.SetSharedListener(a.session(), [&calls] { ++calls; });
  const int before = calls;
  ASSERT_TRUE(a.Send(a.EmptyBatch()).ok());
  EXPECT_EQ(calls, before);
  ASSERT_TRUE(a.Stream(1).ok());
  EXPECT_EQ(calls, before + 1);
  ASSERT_TRUE(a.Stream().ok());
  EXPECT_EQ(calls, before + 1);
  store_.SetSharedListener(a.session(), nullptr);
}

TEST_F(GlobalPlaceTest, AnotherRobotAloneHasNoGlobalFrame) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream(1).ok());
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(b.TakeShared().ok());
  EXPECT_EQ(b.mirror().updates, 0);
  EXPECT_FALSE(b.mirror().global_from_local.has_value());
}

TEST_F(GlobalPlaceTest, OnceMergedTheOwnKeyframesSayIt) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(a.TakeShared().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  ASSERT_TRUE(a.TakeShared().ok());
  ASSERT_TRUE(b.TakeShared().ok());
  for (const TestAgent* agent : {&a, &b}) {
    EXPECT_FALSE(agent->mirror().own.empty());
    EXPECT_FALSE(agent->mirror().apart);
    EXPECT_EQ(agent->mirror().restarts, 0);
  }
  EXPECT_FALSE(b.mirror().global_from_local.has_value());
}

TEST_F(GlobalPlaceTest, ASessionThatBeginsAgainIsToldAgain) {
  TestAgent a(store_, kMission, "a", map_a_);
  ASSERT_TRUE(a.Stream(2).ok());
  ASSERT_TRUE(a.TakeShared().ok());
  TestAgent again(store_, kMission, "a", map_a_);
  ASSERT_TRUE(again.TakeShared().ok());
  ExpectIdentity(again.mirror().global_from_local);
  EXPECT_EQ(again.mirror().updates, 1);
}

// It goes on in another local map, of which the store has nothing yet.
TEST_F(GlobalPlaceTest, ARobotThatClosedItsLocalMapIsNotToldThatOnesPlaceAnew) {
  TestAgent a(store_, kMission, "a", map_a_);
  ASSERT_TRUE(a.Stream(2).ok());
  ASSERT_TRUE(a.TakeShared().ok());
  ASSERT_TRUE(a.Close().ok());
  TestAgent again(store_, kMission, "a", map_a_);
  ASSERT_TRUE(again.TakeShared().ok());
  EXPECT_FALSE(again.mirror().global_from_local.has_value());
}

// The mission's first robot is far from the others, which meet.
TEST_F(GlobalPlaceTest, RobotsThatMetApartFromTheGlobalFrameHearSo) {
  const SyntheticMap far = MakeRingMap(0xd, 200, 6);
  TruthfulWorker worker{{&far, &map_a_, &map_b_}};
  MapStore store(testing::DeterministicOptions(), testing::TheWorld().vocabulary,
                 std::make_unique<InMemoryJournal>(), &worker);
  TestAgent first(store, kMission, "first", far);
  TestAgent a(store, kMission, "a", map_a_);
  TestAgent b(store, kMission, "b", map_b_);
  ASSERT_TRUE(first.Stream(1).ok());
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(store.RunFusionUntilIdle(kMission).ok());
  ASSERT_EQ(store.GetMission(kMission)->islands, 2u);
  ASSERT_TRUE(a.TakeShared().ok());
  ASSERT_TRUE(b.TakeShared().ok());
  for (const TestAgent* agent : {&a, &b}) {
    EXPECT_FALSE(agent->mirror().own.empty()) << "others' keyframes are placed by them";
    EXPECT_TRUE(agent->mirror().apart);
    EXPECT_FALSE(agent->mirror().global_from_local.has_value());
  }
}

}  // namespace
}  // namespace corbslam::map_store
