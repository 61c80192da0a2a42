// Tests the way from streams to one map: the fusion cycle with a worker that knows the truth, step
// by step.
#include <algorithm>
#include <set>
#include <utility>

#include "map_store/testing/two_robots.h"

namespace corbslam::map_store {
namespace {

using testing::DeterministicOptions;
using testing::MakeRingMap;
using testing::MakeSyntheticMap;
using testing::PosesOnRing;
using testing::SyntheticMap;
using testing::SyntheticMapOptions;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

using FusionFlowTest = testing::TwoRobots;

TEST_F(FusionFlowTest, LoneMapStandsInItsOwnFrameAndFollowsItsOwner) {
  ASSERT_TRUE(a_.Stream().ok());
  Fuse();
  EXPECT_EQ(Statistics().islands, 1u);
  EXPECT_EQ(Statistics().revision, 0u);
  EXPECT_LT(
      Difference(Pose(a_.Id(5)).ToRigid(), map_a_.map.FindKeyframe(a_.Id(5))->camera_from_map),
      1e-12);
}

TEST_F(FusionFlowTest, TwoMapsBecomeOneIslandInTheFirstOnesFrame) {
  StreamBoth();
  Fuse();
  EXPECT_EQ(Statistics().islands, 1u);
  EXPECT_EQ(store_.GetLocalMap(kMission, b_.local_map())->island, a_.local_map());
  EXPECT_TRUE(store_.GetLocalMap(kMission, b_.local_map())->in_reference_island);
  EXPECT_EQ(Statistics().merge_ms.size(), 1u);
  ASSERT_EQ(Statistics().global_adjustments.size(), 1u);
  // The first keyframe holds the frame; the others stand as in truth relative to it, across maps.
  EXPECT_LT(Difference(Pose(a_.Id(0)).ToRigid(), Rigid3d::Identity()), 1e-9);
  for (const uint32_t k : {2u, 6u, 10u}) {
    EXPECT_LT(
        Difference(Relative(a_.Id(0), b_.Id(k)), TrueRelative(map_a_, a_.Id(0), map_b_, b_.Id(k))),
        1e-6);
  }
}

TEST_F(FusionFlowTest, AdjustmentMovesKeyframesNotOnlyPoints) {
  StreamBoth();
  Fuse();
  const Rigid3d drifted = map_a_.map.FindKeyframe(a_.Id(9))->camera_from_map;
  EXPECT_GT(Difference(Pose(a_.Id(9)).ToRigid(), drifted), 1e-3);
  EXPECT_TRUE(store_.GetKeyframe(kMission, a_.Id(9))->placed);
  // The local layer is the owner's, and stays as it was.
  EXPECT_LT(Difference(store_.GetKeyframe(kMission, a_.Id(9))->camera_from_local, drifted), 1e-12);
}

TEST_F(FusionFlowTest, NewKeyframesFollowTheirCorrectedParentWithoutASeam) {
  ASSERT_TRUE(a_.Stream().ok());
  ASSERT_TRUE(b_.Stream(10).ok());
  Fuse();
  ASSERT_EQ(Statistics().islands, 1u);
  ASSERT_TRUE(b_.Stream(4).ok());
  // The newest placed keyframe and all that hang on it keep their local relative poses exactly.
  for (uint32_t k = 6; k < 13; ++k) {
    if (store_.GetKeyframe(kMission, b_.Id(k + 1))->placed) continue;
    const Rigid3d local = map_b_.map.FindKeyframe(b_.Id(k + 1))->camera_from_map *
                          map_b_.map.FindKeyframe(b_.Id(k))->camera_from_map.Inverse();
    EXPECT_LT(Difference(Relative(b_.Id(k), b_.Id(k + 1)), local), 1e-9) << k;
  }
}

// B crosses A's way twice, at places far from each other.
class SecondOverlapTest : public ::testing::Test {
 protected:
  static constexpr char kMission[] = "m";

  static SyntheticMap MakeCrossing() {
    SyntheticMapOptions options;
    options.local_map = {0xb};
    options.seed = 5;
    options.drift_yaw_rad = 0.004;
    std::vector<Rigid3d> poses = PosesOnRing(0, 4, 8);
    const std::vector<Rigid3d> later = PosesOnRing(100, 4, 8);
    poses.insert(poses.end(), later.begin(), later.end());
    return MakeSyntheticMap(TheWorld().world, poses, options);
  }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 36);
  SyntheticMap map_b_ = MakeCrossing();
  TruthfulWorker worker_{{&map_a_, &map_b_}};
  MapStore store_{DeterministicOptions(), TheWorld().vocabulary,
                  std::make_unique<InMemoryJournal>(), &worker_};
};

TEST_F(SecondOverlapTest, MergedMapsAreStillCheckedAndTheNewOverlapJoinsTheGraph) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream(8).ok());
  ASSERT_TRUE(store_.RunFusionUntilIdle(kMission).ok());
  ASSERT_EQ(store_.GetStatistics(kMission)->islands, 1u);
  const uint64_t accepted = store_.GetStatistics(kMission)->overlaps_accepted;
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(a.Close().ok());
  ASSERT_TRUE(b.Close().ok());
  ASSERT_TRUE(store_.RunFusionUntilIdle(kMission).ok());
  EXPECT_GT(store_.GetStatistics(kMission)->overlaps_accepted, accepted);
  EXPECT_EQ(store_.GetStatistics(kMission)->merge_ms.size(), 1u);
  // The last fusing welded inside the island.
  EXPECT_TRUE(worker_.fused().back().source.keyframes().empty());
  const auto overlaps = store_.ListOverlaps(kMission, {true, {}}, {});
  for (const OverlapInfo& info : overlaps->items) {
    EXPECT_TRUE(info.fused);
    EXPECT_GT(info.revision, 0u);
  }
}

TEST_F(FusionFlowTest, EachPairIsAskedOnceAndAnOverlapGivesAHandful) {
  StreamBoth();
  CloseBoth();
  Fuse();
  std::set<std::pair<KeyframeId, KeyframeId>> pairs;
  for (const TruthfulWorker::Asked& asked : worker_.asked()) {
    for (const KeyframeId& candidate : asked.candidates) {
      EXPECT_TRUE(pairs.insert(std::minmax(asked.query, candidate)).second)
          << ToString(asked.query) << " " << ToString(candidate);
    }
  }
  EXPECT_GE(Statistics().overlaps_accepted, 1u);
  EXPECT_LE(Statistics().overlaps_accepted, 5u);
  const size_t asked = worker_.asked().size();
  Fuse();
  EXPECT_EQ(worker_.asked().size(), asked);
}

TEST_F(FusionFlowTest, ProvisionalKeyframesAreNeitherQueriedNorPlaced) {
  StreamBoth();
  Fuse();
  for (const TruthfulWorker::Asked& asked : worker_.asked()) EXPECT_LT(asked.query.index, 11u);
  EXPECT_TRUE(store_.GetKeyframe(kMission, b_.Id(10))->placed);
  EXPECT_FALSE(store_.GetKeyframe(kMission, b_.Id(11))->placed);
  CloseBoth();
  Fuse();
  // The last adjustment places all keyframes.
  EXPECT_TRUE(store_.GetKeyframe(kMission, b_.Id(13))->placed);
}

TEST_F(FusionFlowTest, AfterTheStreamsAnAdjustmentMayTakeLonger) {
  StreamBoth();
  Fuse();
  ASSERT_FALSE(worker_.adjusted().empty());
  EXPECT_EQ(worker_.adjusted().back().max_iterations, MapStoreOptions().adjust_iterations);
  CloseBoth();
  Fuse();
  EXPECT_EQ(worker_.adjusted().back().max_iterations, MapStoreOptions().last_adjust_iterations);
}

TEST_F(FusionFlowTest, LocalLoopBringsAnIslandUpToDate) {
  StreamBoth();
  Fuse();
  const size_t adjustments = Statistics().global_adjustments.size();
  const size_t fusings = worker_.fused().size();
  MapUpdateBatch loop = b_.EmptyBatch();
  loop.loop_edges.push_back({b_.Id(10), b_.Id(0), Similarity3d()});
  ASSERT_TRUE(b_.Send(loop).ok());
  Fuse();
  EXPECT_EQ(worker_.fused().size(), fusings + 1);
  EXPECT_TRUE(worker_.fused().back().source.keyframes().empty());
  EXPECT_GT(Statistics().global_adjustments.size(), adjustments);
}

// Counts adjustments while both robots stream keyframe by keyframe, with a turn of fusion after
// each, and then end.
size_t CountAdjustments(const MapStoreOptions& options, TruthfulWorker& worker,
                        const SyntheticMap& map_a, const SyntheticMap& map_b,
                        size_t* before_the_end = nullptr) {
  MapStore store(options, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker);
  TestAgent a(store, "m", "a", map_a);
  TestAgent b(store, "m", "b", map_b);
  for (size_t k = 0; k < map_a.map.keyframes().size(); ++k) {
    EXPECT_TRUE(a.Stream(1).ok());
    EXPECT_TRUE(b.Stream(1).ok());
    EXPECT_TRUE(store.RunFusionUntilIdle("m").ok());
  }
  EXPECT_EQ(store.GetStatistics("m")->islands, 1u);
  if (before_the_end != nullptr) {
    *before_the_end = store.GetStatistics("m")->global_adjustments.size();
  }
  EXPECT_TRUE(a.Close().ok());
  EXPECT_TRUE(b.Close().ok());
  EXPECT_TRUE(store.RunFusionUntilIdle("m").ok());
  return store.GetStatistics("m")->global_adjustments.size();
}

TEST_F(FusionFlowTest, AdjustmentsAreSpacedByWhatChanged) {
  MapStoreOptions options = DeterministicOptions();
  // The worker is asked about everything, so that overlaps come all the time.
  options.overlap_spacing = 0;
  options.min_shared_landmarks = 100000;
  options.adjust_min_keyframes = 1000;
  size_t before_the_end = 0;
  EXPECT_EQ(CountAdjustments(options, worker_, map_a_, map_b_, &before_the_end), 2u)
      << "after the merge and after the streams";
  EXPECT_EQ(before_the_end, 1u);
  options.adjust_min_keyframes = 1;
  options.adjust_share = 1e-6;
  EXPECT_GT(CountAdjustments(options, worker_, map_a_, map_b_), 2u);
}

TEST_F(FusionFlowTest, RunsTwiceTheSame) {
  const auto run = [this] {
    MapStore store(DeterministicOptions(), TheWorld().vocabulary,
                   std::make_unique<InMemoryJournal>(), &worker_);
    TestAgent a(store, kMission, "a", map_a_);
    TestAgent b(store, kMission, "b", map_b_);
    for (int k = 0; k < 14; ++k) {
      EXPECT_TRUE(a.Stream(1).ok());
      EXPECT_TRUE(b.Stream(1).ok());
      EXPECT_TRUE(store.RunFusionUntilIdle(kMission).ok());
    }
    return store.ListKeyframes(kMission, {}, {})->items;
  };
  const auto first = run();
  const auto second = run();
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].camera_from_island.translation, second[i].camera_from_island.translation);
    EXPECT_EQ(first[i].camera_from_island.rotation.coeffs(),
              second[i].camera_from_island.rotation.coeffs());
  }
}

TEST_F(FusionFlowTest, EveryTrackedFrameIsInTheGlobalTrajectory) {
  StreamBoth();
  auto global = store_.GetTrajectory(kMission, "", TrajectoryFrame::kGlobal);
  ASSERT_TRUE(global.ok());
  ASSERT_EQ(global->size(), 2u);
  EXPECT_EQ((*global)[0].poses.size(), 14u);
  EXPECT_TRUE((*global)[1].poses.empty()) << "not in the reference island before fusing";
  Fuse();
  global = store_.GetTrajectory(kMission, "b", TrajectoryFrame::kGlobal);
  ASSERT_TRUE(global.ok());
  ASSERT_EQ(global->at(0).poses.size(), 14u);
  EXPECT_LT(
      Difference(global->at(0).poses[6].frame_from_camera.Inverse(), Pose(b_.Id(6)).ToRigid()),
      1e-9);
  const auto local = store_.GetTrajectory(kMission, "b", TrajectoryFrame::kLocal);
  EXPECT_LT(Difference(local->at(0).poses[6].frame_from_camera.Inverse(),
                       map_b_.map.FindKeyframe(b_.Id(6))->camera_from_map),
            1e-9);
}

}  // namespace
}  // namespace corbslam::map_store
