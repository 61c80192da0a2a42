// Tests keyframes that a worker found redundant: fusion and the other robots do without them, their
// owner keeps them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/recover_undamaged.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::map_store {
namespace {

using testing::ByteJournal;
using testing::DeterministicOptions;
using testing::JournalBytes;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

constexpr char kMission[] = "m";
constexpr KeyframeId kCulled = {{0xa}, 9};

MapStoreOptions CullingOptions() {
  MapStoreOptions options = DeterministicOptions();
  options.cull_share = 0.9;
  options.cull_target = 20;
  return options;
}

// A and B are fused, then one of A's keyframes is culled; then both go on.
class CullingTest : public ::testing::Test {
 protected:
  void Fuse() { ASSERT_TRUE(store_.RunFusionUntilIdle(kMission).ok()); }
  void CullOne() {
    worker_.redundant = {kCulled};
    ASSERT_TRUE(a_.Stream().ok());
    ASSERT_TRUE(b_.Stream(11).ok());
    Fuse();
    ASSERT_EQ(store_.GetStatistics(kMission)->islands, 1u);
    worker_.redundant.clear();
  }
  Rigid3d Pose(KeyframeId id) {
    return store_.GetKeyframe(kMission, id)->camera_from_island.ToRigid();
  }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
  MapStore store_{CullingOptions(), TheWorld().vocabulary, std::make_unique<InMemoryJournal>(),
                  &worker_};
  TestAgent a_{store_, kMission, "a", map_a_};
  TestAgent b_{store_, kMission, "b", map_b_};
};

TEST_F(CullingTest, TheWorkerIsToldWhatIsRedundant) {
  CullOne();
  ASSERT_FALSE(worker_.adjusted().empty());
  EXPECT_EQ(worker_.adjusted().back().redundant_share, 0.9);
  EXPECT_EQ(worker_.adjusted().back().target_keyframes, 20u);
}

TEST_F(CullingTest, LaterAdjustmentsGoWithoutItAndItFollowsItsRelatives) {
  CullOne();
  ASSERT_TRUE(a_.Close().ok());
  ASSERT_TRUE(b_.Stream().ok());
  ASSERT_TRUE(b_.Close().ok());
  const size_t adjusted_before = worker_.adjusted().size();
  Fuse();
  ASSERT_GT(worker_.adjusted().size(), adjusted_before);
  EXPECT_EQ(worker_.adjusted().back().view.FindKeyframe(kCulled), nullptr);
  EXPECT_EQ(worker_.adjusted().back().view.keyframes().size(), 27u);
  // The culled keyframe stands between its neighbours, as far from them as its owner says.
  const Rigid3d global = Pose(kCulled) * Pose({{0xa}, 8}).Inverse();
  const Rigid3d local = map_a_.map.FindKeyframe(kCulled)->camera_from_map *
                        map_a_.map.FindKeyframe({{0xa}, 8})->camera_from_map.Inverse();
  EXPECT_LT((global.translation - local.translation).norm(), 1e-9);
}

TEST_F(CullingTest, OthersForgetItItsOwnerDoesNot) {
  worker_.redundant.clear();
  ASSERT_TRUE(a_.Stream().ok());
  ASSERT_TRUE(b_.Stream(11).ok());
  Fuse();
  ASSERT_TRUE(b_.TakeShared().ok());
  ASSERT_TRUE(b_.mirror().keyframes.contains(kCulled));
  worker_.redundant = {kCulled};
  ASSERT_TRUE(b_.Stream().ok());
  ASSERT_TRUE(a_.Close().ok());
  ASSERT_TRUE(b_.Close().ok());
  Fuse();
  ASSERT_TRUE(b_.TakeShared().ok());
  EXPECT_FALSE(b_.mirror().keyframes.contains(kCulled));
  EXPECT_EQ(store_.GetLocalMap(kMission, a_.local_map())->keyframes, 14u);
}

// A worker may be wrong about a keyframe that it was asked about; others are none of its business.
TEST_F(CullingTest, NothingIsCulledThatWasNotInView) {
  const auto bytes = std::make_shared<JournalBytes>();
  MapStore store(CullingOptions(), TheWorld().vocabulary, std::make_unique<ByteJournal>(bytes),
                 &worker_);
  worker_.redundant = {{{0xc}, 1}, {{0xa}, 1000}};
  TestAgent a(store, kMission, "a", map_a_);
  TestAgent b(store, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(store.RunFusionUntilIdle(kMission).ok());
  ASSERT_FALSE(worker_.adjusted().empty());
  MapStore again(CullingOptions(), TheWorld().vocabulary, std::make_unique<ByteJournal>(bytes),
                 nullptr);
  const absl::Status recovered = testing::RecoverUndamaged(again);
  EXPECT_TRUE(recovered.ok()) << recovered;
  EXPECT_EQ(again.GetStatistics(kMission)->revision, store.GetStatistics(kMission)->revision);
}

TEST_F(CullingTest, DerivingAgainTakesItBack) {
  CullOne();
  ASSERT_TRUE(store_.RederiveGlobalLayer(kMission).ok());
  Fuse();
  EXPECT_NE(worker_.adjusted().back().view.FindKeyframe(kCulled), nullptr);
}

}  // namespace
}  // namespace corbslam::map_store
