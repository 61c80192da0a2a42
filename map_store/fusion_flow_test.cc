// From streams to one map: the fusion cycle with a worker that knows the truth, step by step.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <utility>

#include "map_store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam {
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

constexpr char kMission[] = "m";

class FusionFlowTest : public ::testing::Test {
 protected:
  explicit FusionFlowTest(const MapStoreOptions& options = DeterministicOptions())
      : store_(options, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker_) {}

  void Fuse() { ASSERT_TRUE(store_.RunFusionUntilIdle(kMission).ok()); }
  MissionStatistics Statistics() { return *store_.GetStatistics(kMission); }
  Similarity3d Pose(KeyframeId id) { return store_.GetKeyframe(kMission, id)->camera_from_island; }
  // b_from_a by the global layer.
  Rigid3d Relative(KeyframeId a, KeyframeId b) {
    return Pose(b).ToRigid() * Pose(a).ToRigid().Inverse();
  }
  Rigid3d TrueRelative(const SyntheticMap& a, KeyframeId from, const SyntheticMap& b,
                       KeyframeId to) {
    return b.true_camera_from_world.at(to) * a.true_camera_from_world.at(from).Inverse();
  }
  static double Difference(const Rigid3d& a, const Rigid3d& b) {
    const Rigid3d difference = a * b.Inverse();
    return difference.translation.norm() + RotationAngle(difference.rotation);
  }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
  MapStore store_;
};

TEST_F(FusionFlowTest, LoneMapStandsInItsOwnFrameAndFollowsItsOwner) {
  TestAgent a(store_, kMission, "a", map_a_);
  ASSERT_TRUE(a.Stream().ok());
  Fuse();
  EXPECT_EQ(Statistics().islands, 1u);
  EXPECT_EQ(Statistics().revision, 0u);
  EXPECT_LT(Difference(Pose(a.Id(5)).ToRigid(), map_a_.map.FindKeyframe(a.Id(5))->camera_from_map),
            1e-12);
}

TEST_F(FusionFlowTest, TwoMapsBecomeOneIslandInTheFirstOnesFrame) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  EXPECT_EQ(Statistics().islands, 1u);
  EXPECT_EQ(store_.GetLocalMap(kMission, b.local_map())->island, a.local_map());
  EXPECT_TRUE(store_.GetLocalMap(kMission, b.local_map())->in_reference_island);
  EXPECT_EQ(Statistics().merge_ms.size(), 1u);
  ASSERT_EQ(Statistics().global_adjustments.size(), 1u);
  // The first keyframe holds the frame; the rest stands as in truth relative to it, across maps.
  EXPECT_LT(Difference(Pose(a.Id(0)).ToRigid(), Rigid3d::Identity()), 1e-9);
  for (const uint32_t k : {2u, 6u, 10u}) {
    EXPECT_LT(
        Difference(Relative(a.Id(0), b.Id(k)), TrueRelative(map_a_, a.Id(0), map_b_, b.Id(k))),
        1e-6);
  }
}

TEST_F(FusionFlowTest, AdjustmentMovesKeyframesNotOnlyPoints) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  const Rigid3d drifted = map_a_.map.FindKeyframe(a.Id(9))->camera_from_map;
  EXPECT_GT(Difference(Pose(a.Id(9)).ToRigid(), drifted), 1e-3);
  EXPECT_TRUE(store_.GetKeyframe(kMission, a.Id(9))->placed);
  // The local layer is the owner's: untouched.
  EXPECT_LT(Difference(store_.GetKeyframe(kMission, a.Id(9))->camera_from_local, drifted), 1e-12);
}

TEST_F(FusionFlowTest, StaleLightUpdateDoesNotMoveWhatFusionPlaced) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  const Rigid3d before = Pose(a.Id(8)).ToRigid();
  const uint64_t revision = Statistics().revision;
  MapUpdateBatch stale = a.EmptyBatch();
  for (const auto& [id, keyframe] : map_a_.map.keyframes()) {
    stale.light_keyframes.push_back({id, keyframe.camera_from_map, keyframe.parent});
  }
  // One keyframe as it was before the robot's own last adjustment: half a pixel away.
  stale.light_keyframes[8].camera_from_local.translation.x() += 0.0005;
  ASSERT_TRUE(a.Send(stale).ok());
  Fuse();
  EXPECT_LT(Difference(Pose(a.Id(8)).ToRigid(), before), 1e-12);
  EXPECT_EQ(Statistics().revision, revision);
}

TEST_F(FusionFlowTest, NewKeyframesFollowTheirCorrectedParentWithoutASeam) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream(10).ok());
  Fuse();
  ASSERT_EQ(Statistics().islands, 1u);
  ASSERT_TRUE(b.Stream(4).ok());
  // The newest placed one and all that hang on it: the local relative poses, exactly.
  for (uint32_t k = 6; k < 13; ++k) {
    if (store_.GetKeyframe(kMission, b.Id(k + 1))->placed) continue;
    const Rigid3d local = map_b_.map.FindKeyframe(b.Id(k + 1))->camera_from_map *
                          map_b_.map.FindKeyframe(b.Id(k))->camera_from_map.Inverse();
    EXPECT_LT(Difference(Relative(b.Id(k), b.Id(k + 1)), local), 1e-9) << k;
  }
}

// The robot says that a keyframe of another robot's stands for the one that was recognised, and
// that one is in no island of the two that are to be fused.
TEST_F(FusionFlowTest, AnOverlapThatGoesOverToAnotherIslandHoldsNothingUp) {
  const SyntheticMap far = MakeRingMap(0xc, 180, 14);
  TruthfulWorker worker({&map_a_, &map_b_, &far});
  MapStore store(DeterministicOptions(), TheWorld().vocabulary, std::make_unique<InMemoryJournal>(),
                 &worker);
  TestAgent a(store, kMission, "a", map_a_);
  TestAgent b(store, kMission, "b", map_b_);
  TestAgent c(store, kMission, "c", far);
  bool removed = false;
  // While a worker fails to fuse them.
  worker.fuse_failures = {absl::InternalError("try again")};
  OverlapFilter only_accepted;
  only_accepted.accepted = true;
  worker.during_fuse = [&] {
    if (std::exchange(removed, true)) return;
    const auto overlaps = store.ListOverlaps(kMission, only_accepted, {})->items;
    MapUpdateBatch batch = b.EmptyBatch();
    for (const OverlapInfo& overlap : overlaps) {
      batch.removed_keyframes.push_back({overlap.overlap.query, c.Id(3), Rigid3d::Identity()});
    }
    EXPECT_TRUE(b.Send(batch).ok());
  };
  ASSERT_TRUE(c.Stream().ok());
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream(10).ok());
  ASSERT_TRUE(store.RunFusionUntilIdle(kMission).ok());
  EXPECT_TRUE(removed);
  EXPECT_TRUE(*store.IsFusionIdle(kMission));
}

// B crosses A's way twice, at places far from each other.
class SecondOverlapTest : public ::testing::Test {
 protected:
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
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  ASSERT_TRUE(a.Close().ok());
  ASSERT_TRUE(b.Close().ok());
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
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  for (const TruthfulWorker::Asked& asked : worker_.asked()) EXPECT_LT(asked.query.index, 11u);
  EXPECT_TRUE(store_.GetKeyframe(kMission, b.Id(10))->placed);
  EXPECT_FALSE(store_.GetKeyframe(kMission, b.Id(11))->placed);
  ASSERT_TRUE(a.Close().ok());
  ASSERT_TRUE(b.Close().ok());
  Fuse();
  // The last adjustment places all.
  EXPECT_TRUE(store_.GetKeyframe(kMission, b.Id(13))->placed);
}

TEST_F(FusionFlowTest, AfterTheStreamsAnAdjustmentMayTakeLonger) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  ASSERT_FALSE(worker_.adjusted().empty());
  EXPECT_EQ(worker_.adjusted().back().max_iterations, MapStoreOptions().adjust_iterations);
  ASSERT_TRUE(a.Close().ok());
  ASSERT_TRUE(b.Close().ok());
  Fuse();
  EXPECT_EQ(worker_.adjusted().back().max_iterations, MapStoreOptions().last_adjust_iterations);
}

TEST_F(FusionFlowTest, DataThatArrivesDuringAdjustmentIsKeptAndFollows) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream(9).ok());
  int calls = 0;
  worker_.during_adjust = [&](const ProgressCallback&) {
    if (++calls > 1) return true;
    // Keyframes come, one in the snapshot goes, while the worker is busy.
    EXPECT_TRUE(b.Stream(3).ok());
    MapUpdateBatch removal = b.EmptyBatch();
    removal.removed_keyframes.push_back({b.Id(3), b.Id(2), Rigid3d::Identity()});
    EXPECT_TRUE(b.Send(removal).ok());
    return true;
  };
  Fuse();
  ASSERT_GE(calls, 1);
  EXPECT_EQ(store_.GetKeyframe(kMission, b.Id(3)).status().code(), absl::StatusCode::kNotFound);
  EXPECT_LT(Difference(Relative(a.Id(0), b.Id(4)), TrueRelative(map_a_, a.Id(0), map_b_, b.Id(4))),
            1e-6);
  const Rigid3d local = map_b_.map.FindKeyframe(b.Id(11))->camera_from_map *
                        map_b_.map.FindKeyframe(b.Id(10))->camera_from_map.Inverse();
  EXPECT_LT(Difference(Relative(b.Id(10), b.Id(11)), local), 1e-9);
}

TEST_F(FusionFlowTest, RefusedFusingIsKeptWithItsReason) {
  worker_.refuse_fusing = true;
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  EXPECT_EQ(Statistics().islands, 2u);
  EXPECT_EQ(Statistics().revision, 0u);
  const auto overlaps = store_.ListOverlaps(kMission, {}, {});
  ASSERT_TRUE(overlaps.ok());
  ASSERT_FALSE(overlaps->items.empty());
  bool found = false;
  for (const OverlapInfo& info : overlaps->items) {
    EXPECT_FALSE(info.fused);
    if (info.overlap.verdict != OverlapVerdict::kBendsGraph) continue;
    found = true;
    EXPECT_THAT(info.note, ::testing::HasSubstr("bends"));
  }
  EXPECT_TRUE(found);
}

// Several overlaps go into one request: one that bends the graph takes no other along.
TEST_F(FusionFlowTest, OneBadOverlapDoesNotRefuseTheOthers) {
  MapStoreOptions options = DeterministicOptions();
  // Ask everybody, however well linked.
  options.overlap_spacing = 0;
  options.min_shared_landmarks = 100000;
  const auto run = [&] {
    MapStore store(options, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker_);
    TestAgent a(store, kMission, "a", map_a_);
    TestAgent b(store, kMission, "b", map_b_);
    for (TestAgent* agent : {&a, &b}) {
      EXPECT_TRUE(agent->Stream().ok());
      EXPECT_TRUE(agent->Close().ok());
    }
    EXPECT_TRUE(store.RunFusionUntilIdle(kMission).ok());
    return store.ListOverlaps(kMission, {}, {})->items;
  };
  size_t accepted = 0;
  KeyframeId bad;
  for (const OverlapInfo& info : run()) {
    if (!info.overlap.IsAccepted()) continue;
    ++accepted;
    bad = info.overlap.query;
  }
  ASSERT_GT(accepted, 3u);
  worker_.bends_graph = [bad](const Overlap& overlap) { return overlap.query == bad; };
  size_t left = 0;
  bool refused = false;
  for (const OverlapInfo& info : run()) {
    if (info.overlap.IsAccepted()) ++left;
    if (info.overlap.verdict != OverlapVerdict::kBendsGraph) continue;
    EXPECT_EQ(info.overlap.query, bad);
    refused = true;
  }
  EXPECT_TRUE(refused);
  EXPECT_EQ(left, accepted - 1);
}

TEST_F(FusionFlowTest, FailingWorkerIsAskedAgainButNotForEver) {
  worker_.fuse_failures = {absl::InternalError("one"), absl::InternalError("two")};
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  EXPECT_EQ(Statistics().islands, 1u);
  EXPECT_EQ(Statistics().failed_requests, 2u);

  worker_.adjust_failures.assign(20, absl::InternalError("always"));
  ASSERT_TRUE(a.Close().ok());
  ASSERT_TRUE(b.Close().ok());
  Fuse();
  EXPECT_EQ(Statistics().failed_requests, 5u);
  EXPECT_TRUE(*store_.IsFusionIdle(kMission));
}

TEST_F(FusionFlowTest, LocalLoopBringsAnIslandUpToDate) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  Fuse();
  const size_t adjustments = Statistics().global_adjustments.size();
  const size_t fusings = worker_.fused().size();
  MapUpdateBatch loop = b.EmptyBatch();
  loop.loop_edges.push_back({b.Id(10), b.Id(0), Similarity3d()});
  ASSERT_TRUE(b.Send(loop).ok());
  Fuse();
  EXPECT_EQ(worker_.fused().size(), fusings + 1);
  EXPECT_TRUE(worker_.fused().back().source.keyframes().empty());
  EXPECT_GT(Statistics().global_adjustments.size(), adjustments);
}

TEST_F(FusionFlowTest, OwnersGoOnChangingPointsThatAreLandmarks) {
  const SyntheticMap map_c = MakeRingMap(0xc, 180, 5);
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  TestAgent c(store_, kMission, "c", map_c);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  // Not settled, so never compared.
  ASSERT_TRUE(c.Stream(3).ok());
  Fuse();
  ASSERT_FALSE(worker_.fused().empty());
  const FuseMapsRequest fused = worker_.fused().at(0);
  const std::vector<PointPair> pairs = fused.overlaps.at(0).inliers;
  ASSERT_GT(pairs.size(), 20u);
  const auto own_of = [&pairs](size_t i, LocalMapId id) {
    return pairs[i].query.local_map == id ? pairs[i].query : pairs[i].candidate;
  };
  const size_t landmarks = store_.GetMission(kMission)->map_points;
  // The survivor goes, and with it one point, but the other robot's stands for both.
  MapUpdateBatch of_a = a.EmptyBatch();
  of_a.removed_points = {own_of(0, a.local_map())};
  ASSERT_TRUE(a.Send(of_a).ok());
  EXPECT_EQ(store_.GetMission(kMission)->map_points, landmarks);
  // Members are replaced: by one of this island, by one of another, by one that nobody knows.
  MapUpdateBatch of_b = b.EmptyBatch();
  of_b.replacements = {{own_of(1, b.local_map()), own_of(2, a.local_map())},
                       {own_of(3, b.local_map()), map_c.map.points().begin()->first},
                       {own_of(4, b.local_map()), {c.local_map(), 4000000}},
                       {own_of(5, b.local_map()), own_of(5, a.local_map())}};
  ASSERT_TRUE(b.Send(of_b).ok());
  MapUpdateBatch more_of_a = a.EmptyBatch();
  for (size_t i = 1; i < 6; ++i) more_of_a.removed_points.push_back(own_of(i, a.local_map()));
  ASSERT_TRUE(a.Send(more_of_a).ok());
  EXPECT_EQ(store_.GlobalMapView(kMission)->size(), 2u);
  ASSERT_TRUE(a.Close().ok());
  ASSERT_TRUE(b.Close().ok());
  Fuse();
  EXPECT_TRUE(b.TakeShared().ok());
  std::set<MapPointId> seen;
  const auto views = store_.GlobalMapView(kMission);
  for (const IslandView& view : *views) {
    for (const IslandView::Point& point : view.points) seen.insert(point.id);
  }
  EXPECT_TRUE(seen.contains(own_of(0, b.local_map())));
  EXPECT_TRUE(seen.contains(own_of(2, b.local_map())));
  EXPECT_FALSE(seen.contains(own_of(5, b.local_map()))) << "both owners let go of it";
}

TEST_F(FusionFlowTest, RejectedObservationsGetASecondChance) {
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  const KeyframeId keyframe = a.Id(1);
  const auto seen = map_a_.map.FindKeyframe(keyframe)->points;
  const auto first = std::find_if(seen.begin(), seen.end(), [](auto id) { return id.IsValid(); });
  ASSERT_NE(first, seen.end());
  const size_t observed = store_.GetKeyframe(kMission, keyframe)->observed_points;
  worker_.reject = {{*first, keyframe}};
  Fuse();
  EXPECT_EQ(store_.GetKeyframe(kMission, keyframe)->observed_points, observed - 1);
  // The owner's layer is untouched, and the next adjustment sees it again.
  worker_.reject.clear();
  ASSERT_TRUE(a.Close().ok());
  ASSERT_TRUE(b.Close().ok());
  Fuse();
  EXPECT_EQ(store_.GetKeyframe(kMission, keyframe)->observed_points, observed);
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
  TestAgent a(store_, kMission, "a", map_a_);
  TestAgent b(store_, kMission, "b", map_b_);
  ASSERT_TRUE(a.Stream().ok());
  ASSERT_TRUE(b.Stream().ok());
  auto global = store_.GetTrajectory(kMission, "", TrajectoryFrame::kGlobal);
  ASSERT_TRUE(global.ok());
  ASSERT_EQ(global->size(), 2u);
  EXPECT_EQ((*global)[0].poses.size(), 14u);
  EXPECT_TRUE((*global)[1].poses.empty()) << "not in the reference island before fusing";
  Fuse();
  global = store_.GetTrajectory(kMission, "b", TrajectoryFrame::kGlobal);
  ASSERT_TRUE(global.ok());
  ASSERT_EQ(global->at(0).poses.size(), 14u);
  EXPECT_LT(Difference(global->at(0).poses[6].frame_from_camera.Inverse(), Pose(b.Id(6)).ToRigid()),
            1e-9);
  const auto local = store_.GetTrajectory(kMission, "b", TrajectoryFrame::kLocal);
  EXPECT_LT(Difference(local->at(0).poses[6].frame_from_camera.Inverse(),
                       map_b_.map.FindKeyframe(b.Id(6))->camera_from_map),
            1e-9);
}

}  // namespace
}  // namespace corbslam
