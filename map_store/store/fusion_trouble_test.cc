// Tests the fusion cycle when something is in its way: refusals, failures, and owners that go on
// changing what is being fused.
#include <gmock/gmock.h>

#include <algorithm>
#include <set>
#include <utility>

#include "map_store/testing/two_robots.h"

namespace corbslam::map_store {
namespace {

using testing::DeterministicOptions;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

using FusionTroubleTest = testing::TwoRobots;

TEST_F(FusionTroubleTest, StaleLightUpdateDoesNotMoveWhatFusionPlaced) {
  StreamBoth();
  Fuse();
  const Rigid3d before = Pose(a_.Id(8)).ToRigid();
  const uint64_t revision = Statistics().revision;
  MapUpdateBatch stale = a_.EmptyBatch();
  for (const auto& [id, keyframe] : map_a_.map.keyframes()) {
    stale.light_keyframes.push_back({id, keyframe.camera_from_map, keyframe.parent});
  }
  // One keyframe stands as it did before the robot's own last adjustment: half a pixel away.
  stale.light_keyframes[8].camera_from_local.translation.x() += 0.0005;
  ASSERT_TRUE(a_.Send(stale).ok());
  Fuse();
  EXPECT_LT(Difference(Pose(a_.Id(8)).ToRigid(), before), 1e-12);
  EXPECT_EQ(Statistics().revision, revision);
}

// The robot removes the recognised keyframe, and says that one of another robot stands for it; that
// one is in neither of the two islands that are to be fused.
TEST_F(FusionTroubleTest, AnOverlapThatGoesOverToAnotherIslandHoldsNothingUp) {
  const SyntheticMap far = MakeRingMap(0xc, 180, 14);
  TruthfulWorker worker({&map_a_, &map_b_, &far});
  MapStore store(DeterministicOptions(), TheWorld().vocabulary, std::make_unique<InMemoryJournal>(),
                 &worker);
  TestAgent a(store, kMission, "a", map_a_);
  TestAgent b(store, kMission, "b", map_b_);
  TestAgent c(store, kMission, "c", far);
  bool removed = false;
  // This happens while a worker fails to fuse the two.
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

TEST_F(FusionTroubleTest, DataThatArrivesDuringAdjustmentIsKeptAndFollows) {
  ASSERT_TRUE(a_.Stream().ok());
  ASSERT_TRUE(b_.Stream(9).ok());
  int calls = 0;
  worker_.during_adjust = [&](const ProgressCallback&) {
    if (++calls > 1) return true;
    // While the worker is busy, keyframes come, and one that is in the snapshot goes.
    EXPECT_TRUE(b_.Stream(3).ok());
    MapUpdateBatch removal = b_.EmptyBatch();
    removal.removed_keyframes.push_back({b_.Id(3), b_.Id(2), Rigid3d::Identity()});
    EXPECT_TRUE(b_.Send(removal).ok());
    return true;
  };
  Fuse();
  ASSERT_GE(calls, 1);
  EXPECT_EQ(store_.GetKeyframe(kMission, b_.Id(3)).status().code(), absl::StatusCode::kNotFound);
  EXPECT_LT(
      Difference(Relative(a_.Id(0), b_.Id(4)), TrueRelative(map_a_, a_.Id(0), map_b_, b_.Id(4))),
      1e-6);
  const Rigid3d local = map_b_.map.FindKeyframe(b_.Id(11))->camera_from_map *
                        map_b_.map.FindKeyframe(b_.Id(10))->camera_from_map.Inverse();
  EXPECT_LT(Difference(Relative(b_.Id(10), b_.Id(11)), local), 1e-9);
}

TEST_F(FusionTroubleTest, RefusedFusingIsKeptWithItsReason) {
  worker_.refuse_fusing = true;
  StreamBoth();
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

TEST_F(FusionTroubleTest, WhatNobodyLookedAtIsKnown) {
  EXPECT_TRUE(store_.has_worker());
  worker_.verify_failures.assign(1000, absl::UnavailableError("gone"));
  StreamBoth();
  const std::vector<UncomparedPair> waiting = Statistics().uncompared;
  ASSERT_FALSE(waiting.empty());
  uint64_t look_ups = 0;
  for (const UncomparedPair& pair : waiting) look_ups += pair.waiting;
  EXPECT_EQ(store_.GetMission(kMission)->waiting_queries, look_ups);
  EXPECT_FALSE(store_.worker_outage().has_value()) << "nobody was asked";
  // Without threads nobody waits for a worker: what fails is given up.
  Fuse();
  ASSERT_TRUE(store_.GetMission(kMission)->worker_outage.has_value());
  EXPECT_EQ(store_.worker_outage()->cause, "gone");
  uint64_t failed = 0;
  for (const UncomparedPair& pair : Statistics().uncompared) {
    EXPECT_EQ(pair.waiting, 0u);
    failed += pair.failed;
  }
  EXPECT_GT(failed, 0u);
  worker_.verify_failures.clear();
  ASSERT_TRUE(store_.RederiveGlobalLayer(kMission).ok());
  Fuse();
  EXPECT_FALSE(store_.worker_outage().has_value());
  EXPECT_TRUE(Statistics().uncompared.empty());
  EXPECT_EQ(Statistics().islands, 1u);
}

// Several overlaps go into one request: one that bends the graph takes no other along.
TEST_F(FusionTroubleTest, OneBadOverlapDoesNotRefuseTheOthers) {
  MapStoreOptions options = DeterministicOptions();
  // The worker is asked about all keyframes, however well they are linked.
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

TEST_F(FusionTroubleTest, FailingWorkerIsAskedAgainButNotForEver) {
  worker_.fuse_failures = {absl::InternalError("one"), absl::InternalError("two")};
  StreamBoth();
  Fuse();
  EXPECT_EQ(Statistics().islands, 1u);
  EXPECT_EQ(Statistics().failed_requests, 2u);

  worker_.adjust_failures.assign(20, absl::InternalError("always"));
  CloseBoth();
  Fuse();
  EXPECT_EQ(Statistics().failed_requests, 5u);
  EXPECT_TRUE(*store_.IsFusionIdle(kMission));
}

TEST_F(FusionTroubleTest, OwnersGoOnChangingPointsThatAreLandmarks) {
  const SyntheticMap map_c = MakeRingMap(0xc, 180, 5);
  TestAgent c(store_, kMission, "c", map_c);
  StreamBoth();
  // C's keyframes are not settled, so that they are never compared.
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
  // The survivor goes, and with it one point, but the other robot's point stands for both.
  MapUpdateBatch of_a = a_.EmptyBatch();
  of_a.removed_points = {own_of(0, a_.local_map())};
  ASSERT_TRUE(a_.Send(of_a).ok());
  EXPECT_EQ(store_.GetMission(kMission)->map_points, landmarks);
  // Members are replaced by a point of this island, by one of another island, and by one that
  // nobody knows.
  MapUpdateBatch of_b = b_.EmptyBatch();
  of_b.replacements = {{own_of(1, b_.local_map()), own_of(2, a_.local_map())},
                       {own_of(3, b_.local_map()), map_c.map.points().begin()->first},
                       {own_of(4, b_.local_map()), {c.local_map(), 4000000}},
                       {own_of(5, b_.local_map()), own_of(5, a_.local_map())}};
  ASSERT_TRUE(b_.Send(of_b).ok());
  MapUpdateBatch more_of_a = a_.EmptyBatch();
  for (size_t i = 1; i < 6; ++i) more_of_a.removed_points.push_back(own_of(i, a_.local_map()));
  ASSERT_TRUE(a_.Send(more_of_a).ok());
  EXPECT_EQ(store_.GlobalMapView(kMission)->size(), 2u);
  CloseBoth();
  Fuse();
  EXPECT_TRUE(b_.TakeShared().ok());
  std::set<MapPointId> seen;
  const auto views = store_.GlobalMapView(kMission);
  for (const IslandView& view : *views) {
    for (const IslandView::Point& point : view.points) seen.insert(point.id);
  }
  EXPECT_TRUE(seen.contains(own_of(0, b_.local_map())));
  EXPECT_TRUE(seen.contains(own_of(2, b_.local_map())));
  EXPECT_FALSE(seen.contains(own_of(5, b_.local_map()))) << "both owners let go of it";
}

TEST_F(FusionTroubleTest, RejectedObservationsGetASecondChance) {
  StreamBoth();
  const KeyframeId keyframe = a_.Id(1);
  const auto seen = map_a_.map.FindKeyframe(keyframe)->points;
  const auto first = std::find_if(seen.begin(), seen.end(), [](auto id) { return id.IsValid(); });
  ASSERT_NE(first, seen.end());
  const size_t observed = store_.GetKeyframe(kMission, keyframe)->observed_points;
  worker_.reject = {{*first, keyframe}};
  Fuse();
  EXPECT_EQ(store_.GetKeyframe(kMission, keyframe)->observed_points, observed - 1);
  // The owner's layer is untouched, and the next adjustment lets the keyframe see the point again.
  worker_.reject.clear();
  CloseBoth();
  Fuse();
  EXPECT_EQ(store_.GetKeyframe(kMission, keyframe)->observed_points, observed);
}

}  // namespace
}  // namespace corbslam::map_store
