#include "map_store/retiring/retirement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

#include "map_store/records/record_application.h"
#include "map_store/retiring/retiring_pass.h"
#include "map_store/testing/small_mission.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

using ::testing::HasSubstr;
using testing::kSmallMapA;
using testing::kSmallMapB;

constexpr KeyframeId kFirst{kSmallMapA, 0};
constexpr KeyframeId kSecond{kSmallMapA, 1};
constexpr KeyframeId kElsewhere{kSmallMapB, 0};

// The small mission after its fusing, with both local maps closed unless a test says otherwise.
class RetirementTest : public ::testing::Test {
 protected:
  RetirementTest() {
    const std::vector<JournalRecord> records = testing::MakeSmallMission();
    for (size_t i = 0; i < 4; ++i) Apply(records[i]);
    for (const LocalMapId& id : {kSmallMapA, kSmallMapB}) state_.FindLocalMap(id)->closed = true;
  }
  void Apply(const JournalRecord& record) {
    if (const auto* batch = std::get_if<BatchRecord>(&record)) {
      map_store::Apply(*batch, {}, {}, state_);
    } else if (const auto* query = std::get_if<QueryRecord>(&record)) {
      map_store::Apply(*query, {}, state_);
    } else {
      const auto& fuse = std::get<FuseRecord>(record);
      RevisionLayers layers = PrepareLayers(fuse.plan, {}, state_);
      map_store::Apply(fuse, layers, state_);
    }
  }
  static Retirement OfSecond() {
    Retirement retirement;
    retirement.keyframes = {{kSecond, kFirst, {}, {kElsewhere, {}}}};
    return retirement;
  }
  std::string Refusal(const Retirement& retirement) {
    const absl::Status status = CheckRetirement(retirement, state_);
    EXPECT_TRUE(absl::IsDataLoss(status)) << status;
    return std::string(status.message());
  }

  MissionState state_;
};

TEST_F(RetirementTest, TheKeyframeGoesAndItsRelativesAreKnown) {
  const uint64_t bytes = state_.FindLocalMap(kSmallMapA)->stored_bytes;
  ASSERT_TRUE(CheckRetirement(OfSecond(), state_).ok());
  ApplyRetirement(OfSecond(), state_);
  EXPECT_EQ(state_.FindKeyframe(kSecond), nullptr);
  EXPECT_EQ(state_.FindLocalMap(kSmallMapA)->retired_keyframes, 1u);
  EXPECT_LT(state_.FindLocalMap(kSmallMapA)->stored_bytes, bytes);
  LivingRelative found;
  ASSERT_TRUE(FindLivingRelative(state_, kSecond, found));
  EXPECT_EQ(found.id, kElsewhere);
  ASSERT_TRUE(FindLivingRelative(state_, kSecond, found, RelativeIn::kLocalLayer));
  EXPECT_EQ(found.id, kFirst);
  EXPECT_FALSE(state_.global.keyframes.contains(kSecond));
}

// What both keyframes of the local map saw stays with the one that is left.
TEST_F(RetirementTest, PointsStayWhereTheyAreAndFollowAnother) {
  const auto place = [&](MapPointId id) { return FindPlaced(id, state_.global); };
  const MapPointId point{kSmallMapA, 1};
  const Eigen::Vector3d before = place(point)->PositionInIsland();
  Retirement retirement;
  retirement.keyframes = {{kFirst, kSecond, {}, {kElsewhere, {}}}};
  ApplyRetirement(retirement, state_);
  ASSERT_TRUE(place(point).has_value());
  EXPECT_LT((place(point)->PositionInIsland() - before).norm(), 1e-12);
  EXPECT_EQ(state_.FindPoint(point)->reference, kSecond);
  EXPECT_EQ(state_.global.points.at(point).anchor, kSecond);
}

TEST_F(RetirementTest, PointsThatNobodyOfTheirOwnSeesGoToTheirHeirs) {
  Retirement retirement = OfSecond();
  // The other keyframe of the local map sees nothing any more.
  LocalMapState& local_map = *state_.FindLocalMap(kSmallMapA);
  for (uint32_t p = 0; p < 6; ++p) local_map.map.RemoveObservation({kSmallMapA, p}, kFirst);
  ApplyRetirement(retirement, state_);
  EXPECT_TRUE(local_map.map.points().empty());
  EXPECT_EQ(ResolvePoint(state_, {kSmallMapA, 1}), (MapPointId{kSmallMapB, 1}));
  EXPECT_FALSE(ResolvePoint(state_, {kSmallMapA, 2}).IsValid());
  EXPECT_EQ(local_map.faded_points, 0u);
}

TEST_F(RetirementTest, FadedLandmarksAreGoneForAll) {
  Retirement retirement;
  retirement.faded = {{kSmallMapA, 1}, {kSmallMapB, 1}};
  ASSERT_TRUE(CheckRetirement(retirement, state_).ok());
  const uint64_t version = state_.version;
  ApplyRetirement(retirement, state_);
  for (const LocalMapId& id : {kSmallMapA, kSmallMapB}) {
    EXPECT_FALSE(ResolvePoint(state_, {id, 1}).IsValid());
    EXPECT_EQ(state_.FindLocalMap(id)->faded_points, 1u);
    const auto changes = state_.FindLocalMap(id)->changes.Since(version);
    ASSERT_TRUE(changes.has_value());
    EXPECT_THAT(changes->landmarks, ::testing::Contains(MapPointId{id, 1}));
  }
  EXPECT_TRUE(state_.global.landmarks.sets().empty());
  // Twice is once.
  ApplyRetirement(retirement, state_);
  EXPECT_EQ(state_.FindLocalMap(kSmallMapA)->faded_points, 1u);
}

TEST_F(RetirementTest, CallsForNoAdjustment) {
  Island& island = *state_.FindIslandOf(kSmallMapA);
  const uint64_t shared = island.shared_version;
  island.dirty = false;
  ApplyRetirement(OfSecond(), state_);
  EXPECT_FALSE(island.dirty);
  EXPECT_GT(island.shared_version, shared) << "robots are told";
}

TEST_F(RetirementTest, ARecordThatNoStoreWroteIsRefused) {
  Retirement retirement = OfSecond();
  retirement.keyframes.push_back(retirement.keyframes[0]);
  EXPECT_THAT(Refusal(retirement), HasSubstr("twice"));
  retirement = OfSecond();
  retirement.keyframes[0].id.index = 77;
  EXPECT_THAT(Refusal(retirement), HasSubstr("not there"));
  retirement = OfSecond();
  retirement.keyframes[0].parent = kElsewhere;
  EXPECT_THAT(Refusal(retirement), HasSubstr("don't stay"));
  retirement = OfSecond();
  retirement.keyframes[0].stand_in.keyframe = kSecond;
  EXPECT_THAT(Refusal(retirement), HasSubstr("don't stay"));
  state_.FindLocalMap(kSmallMapA)->closed = false;
  EXPECT_THAT(Refusal(OfSecond()), HasSubstr("not closed"));
  retirement = {};
  retirement.faded = {{kSmallMapA, 1}};
  EXPECT_THAT(Refusal(retirement), HasSubstr("not closed"));
}

TEST_F(RetirementTest, PartsAreTheWhole) {
  Retirement retirement;
  for (uint32_t i = 0; i < 9; ++i) {
    retirement.keyframes.push_back({{kSmallMapA, i + 1}, kFirst, {}, {kElsewhere, {}}});
  }
  for (uint32_t i = 0; i < 1001; ++i) retirement.faded.push_back({kSmallMapA, i});
  std::vector<KeyframeId> keyframes;
  std::vector<MapPointId> faded;
  const std::vector<Retirement> parts = CutIntoParts(retirement);
  for (const Retirement& part : parts) {
    EXPECT_FALSE(part.empty());
    EXPECT_LE(part.keyframes.size(), 4u);
    for (const RetiredKeyframe& one : part.keyframes) keyframes.push_back(one.id);
    faded.insert(faded.end(), part.faded.begin(), part.faded.end());
  }
  EXPECT_EQ(parts.size(), 6u);
  EXPECT_EQ(keyframes.size(), 9u);
  EXPECT_EQ(faded, retirement.faded);
  EXPECT_TRUE(CutIntoParts({}).empty());
}

TEST_F(RetirementTest, WhatIsClosedAndJoinedIsLookedAtOnce) {
  RetiringPasses passes;
  ASSERT_TRUE(passes.IsDue(state_));
  std::vector<LocalMapId> seen;
  while (const auto stretch = passes.Next(state_)) {
    seen.push_back(stretch->local_map);
    EXPECT_EQ(stretch->keyframes.size(), 4u);
    passes.NoteDone(*stretch);
  }
  EXPECT_THAT(seen, ::testing::ElementsAre(kSmallMapA, kSmallMapB));
  EXPECT_FALSE(passes.IsDue(state_));
  state_.FindLocalMap(kSmallMapB)->closed = false;
  EXPECT_FALSE(RetiringPasses().IsDue(state_)) << "there is one closed local map alone";
}

}  // namespace
}  // namespace corbslam::map_store
