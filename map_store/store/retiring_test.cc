// Tests missions of one place that is driven over again and again: what the store lets go of, and
// that nobody is the worse for it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/drive_views.h"
#include "map_store/testing/recover_undamaged.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::map_store {
namespace {

using testing::ByteJournal;
using testing::DeterministicOptions;
using testing::JournalBytes;
using testing::SyntheticMap;
using testing::SyntheticWorld;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

constexpr char kMission[] = "m";
constexpr size_t kSessions = 4;
constexpr size_t kKeyframes = 14;

// Drives over the same part of the ring as all other sessions, a little aside.
SyntheticMap Drive(uint64_t session, const SyntheticWorld& world) {
  testing::SyntheticMapOptions options;
  options.local_map = {session};
  options.seed = session;
  options.drift_yaw_rad = 0.002;
  return MakeSyntheticMap(world, testing::PosesOnRing(static_cast<double>(session), 4, kKeyframes),
                          options);
}

std::vector<SyntheticMap> DriveAll(const SyntheticWorld& first, const SyntheticWorld& later) {
  std::vector<SyntheticMap> drives;
  for (uint64_t session = 1; session <= kSessions; ++session) {
    drives.push_back(Drive(session, session == 1 ? first : later));
  }
  return drives;
}

MapStoreOptions RetiringOptions() {
  MapStoreOptions options = DeterministicOptions();
  options.retire = true;
  return options;
}

// A store in which robots drive one after the other.
class Street {
 public:
  Street(const MapStoreOptions& options, std::vector<SyntheticMap> drives)
      : drives_(std::move(drives)),
        worker_({&drives_[0], &drives_[1], &drives_[2], &drives_[3]}),
        store_(options, TheWorld().vocabulary, std::make_unique<ByteJournal>(bytes_), &worker_) {}

  TestAgent& Begin(size_t session) {
    agents_.push_back(std::make_unique<TestAgent>(store_, kMission, absl::StrCat("r", session + 1),
                                                  drives_[session]));
    return *agents_.back();
  }
  void Run(size_t session) {
    TestAgent& agent = Begin(session);
    ASSERT_TRUE(agent.Stream().ok());
    ASSERT_TRUE(agent.Close().ok());
    Fuse();
    sizes_.push_back(store_.GetMission(kMission)->keyframes);
  }
  void RunAll() {
    for (size_t session = 0; session < kSessions; ++session) Run(session);
  }
  void Fuse() { ASSERT_TRUE(store_.RunFusionUntilIdle(kMission).ok()); }

  MapStore& store() { return store_; }
  TestAgent& agent(size_t session) { return *agents_[session]; }
  const std::vector<SyntheticMap>& drives() const { return drives_; }
  const std::shared_ptr<JournalBytes>& bytes() const { return bytes_; }
  // Keyframes in the store after each session.
  const std::vector<size_t>& sizes() const { return sizes_; }
  LocalMapInfo LocalMap(uint64_t session) { return *store_.GetLocalMap(kMission, {session}); }
  std::vector<KeyframeId> Retired(uint64_t session) {
    std::vector<KeyframeId> retired;
    for (uint32_t i = 0; i < kKeyframes; ++i) {
      const KeyframeId id = {{session}, i};
      if (!store_.GetKeyframe(kMission, id).ok()) retired.push_back(id);
    }
    return retired;
  }

 private:
  const std::vector<SyntheticMap> drives_;
  TruthfulWorker worker_;
  std::shared_ptr<JournalBytes> bytes_ = std::make_shared<JournalBytes>();
  MapStore store_;
  std::vector<std::unique_ptr<TestAgent>> agents_;
  std::vector<size_t> sizes_;
};

Street Static(const MapStoreOptions& options = RetiringOptions()) {
  return {options, DriveAll(TheWorld().world, TheWorld().world)};
}

TEST(RetiringTest, TheMapsSizeIsThatOfThePlace) {
  Street street = Static();
  street.RunAll();
  const std::vector<size_t>& sizes = street.sizes();
  ASSERT_EQ(sizes.size(), kSessions);
  EXPECT_EQ(sizes[0], kKeyframes) << "a session alone keeps all";
  EXPECT_LT(sizes[3], 2 * kKeyframes);
  EXPECT_LE(sizes[3], sizes[1] + kKeyframes / 2);
  EXPECT_EQ(street.store().GetStatistics(kMission)->islands, 1u);
  EXPECT_TRUE(*street.store().IsFusionIdle(kMission));
  size_t retired = 0;
  for (uint64_t session = 1; session <= kSessions; ++session) {
    const LocalMapInfo info = street.LocalMap(session);
    EXPECT_EQ(info.keyframes + info.retired_keyframes, kKeyframes);
    EXPECT_EQ(info.faded_points, 0u) << "all is still there";
    EXPECT_GE(info.keyframes, 1u);
    retired += info.retired_keyframes;
  }
  EXPECT_EQ(retired, kSessions * kKeyframes - sizes[3]);
}

// A fleet's worker is always short of time at some hour: what is known goes all the same.
TEST(RetiringTest, LookUpsThatWaitKeepNothing) {
  const std::vector<SyntheticMap> drives = DriveAll(TheWorld().world, TheWorld().world);
  TruthfulWorker worker({&drives[0], &drives[1], &drives[2], &drives[3]});
  MapStoreOptions options = RetiringOptions();
  options.deterministic = false;
  options.overlap_spacing = 0;  // Each keyframe asks.
  options.min_shared_landmarks = 100000;
  std::unique_ptr<MapStore> store;
  absl::Notification all_there;
  std::atomic<size_t> retired_meanwhile = 0;
  worker.during_verify = [&] {
    all_there.WaitForNotification();
    if (store->GetMission(kMission)->waiting_queries < 2) return;
    size_t retired = 0;
    for (uint64_t session = 1; session <= kSessions; ++session) {
      const auto local_map = store->GetLocalMap(kMission, {session});
      if (local_map.ok()) retired += local_map->retired_keyframes;
    }
    retired_meanwhile = std::max(retired_meanwhile.load(), retired);
  };
  store = std::make_unique<MapStore>(options, TheWorld().vocabulary,
                                     std::make_unique<InMemoryJournal>(), &worker);
  for (size_t session = 0; session < kSessions; ++session) {
    TestAgent agent(*store, kMission, absl::StrCat("r", session + 1), drives[session]);
    ASSERT_TRUE(agent.Stream().ok());
    ASSERT_TRUE(agent.Close().ok());
  }
  all_there.Notify();
  ASSERT_TRUE(store->WaitUntilFusionIdle(kMission, absl::Seconds(60)).ok());
  EXPECT_GT(retired_meanwhile, 0u);
}

// Nor does an adjustment that takes hours, because the worker gets no processor, keep what is
// known.
TEST(RetiringTest, AnAdjustmentWithoutEndKeepsNothingForLong) {
  const std::vector<SyntheticMap> drives = DriveAll(TheWorld().world, TheWorld().world);
  TruthfulWorker worker({&drives[0], &drives[1], &drives[2], &drives[3]});
  absl::Notification adjusting;
  absl::Notification give_up;
  worker.during_adjust = [&](const ProgressCallback&) {
    if (!adjusting.HasBeenNotified()) adjusting.Notify();
    give_up.WaitForNotification();
    return false;
  };
  std::atomic<int64_t> minutes = 0;
  MapStoreOptions options = RetiringOptions();
  options.deterministic = false;
  MapStore store(options, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), &worker,
                 [&minutes] { return absl::UnixEpoch() + absl::Minutes(minutes.load()); });
  const auto drive = [&](size_t session) {
    TestAgent agent(store, kMission, absl::StrCat("r", session + 1), drives[session]);
    ASSERT_TRUE(agent.Stream().ok());
    ASSERT_TRUE(agent.Close().ok());
  };
  const auto count_retired = [&] {
    size_t retired = 0;
    for (uint64_t session = 1; session <= kSessions; ++session) {
      const auto local_map = store.GetLocalMap(kMission, {session});
      if (local_map.ok()) retired += local_map->retired_keyframes;
    }
    return retired;
  };
  drive(0);
  drive(1);
  ASSERT_TRUE(adjusting.WaitForNotificationWithTimeout(absl::Seconds(60)));
  drive(2);
  for (int i = 0; i < 300 && store.GetMission(kMission)->waiting_queries > 0; ++i) {
    absl::SleepFor(absl::Milliseconds(100));
  }
  EXPECT_EQ(count_retired(), 0u) << "who adjusts is waited for";
  minutes = 2;
  drive(3);
  for (int i = 0; i < 300 && count_retired() == 0; ++i) absl::SleepFor(absl::Milliseconds(100));
  EXPECT_GT(count_retired(), 0u);
  EXPECT_FALSE(*store.IsFusionIdle(kMission));
  give_up.Notify();
}

TEST(RetiringTest, UnlessToldToNothingGoes) {
  Street street = Static(DeterministicOptions());
  street.RunAll();
  EXPECT_EQ(street.sizes().back(), kSessions * kKeyframes);
}

TEST(RetiringTest, TrajectoriesAreWhatTheyWouldHaveBeen) {
  Street street = Static();
  Street whole = Static(DeterministicOptions());
  street.RunAll();
  whole.RunAll();
  ASSERT_FALSE(street.Retired(1).empty());
  for (const TrajectoryFrame frame : {TrajectoryFrame::kGlobal, TrajectoryFrame::kLocal}) {
    const auto with =
        street.store().GetTrajectory(kMission, "", frame, false, PosesOf::kRectifiedCamera);
    const auto without =
        whole.store().GetTrajectory(kMission, "", frame, false, PosesOf::kRectifiedCamera);
    ASSERT_TRUE(with.ok()) << with.status();
    ASSERT_EQ(with->size(), without->size());
    for (size_t agent = 0; agent < with->size(); ++agent) {
      const std::vector<StoredPose>& poses = (*with)[agent].poses;
      ASSERT_EQ(poses.size(), (*without)[agent].poses.size());
      for (size_t i = 0; i < poses.size(); ++i) {
        const Rigid3d& other = (*without)[agent].poses[i].frame_from_camera;
        EXPECT_LT((poses[i].frame_from_camera.translation - other.translation).norm(), 1e-6);
      }
    }
  }
}

TEST(RetiringTest, AReplayComesToTheSame) {
  Street street = Static();
  street.RunAll();
  const std::string local = testing::DumpLocal(kMission, street.store());
  const std::string global = testing::DumpGlobal(kMission, street.store());
  for (const bool from_snapshot : {false, true}) {
    if (from_snapshot) {
      street.bytes()->wants_snapshot = true;
      street.Fuse();
      ASSERT_TRUE(street.bytes()->records.empty());
    }
    // Without a worker nothing more is let go of.
    MapStore again(RetiringOptions(), TheWorld().vocabulary,
                   std::make_unique<ByteJournal>(street.bytes()), nullptr);
    const absl::Status recovered = testing::RecoverUndamaged(again);
    ASSERT_TRUE(recovered.ok()) << recovered;
    EXPECT_EQ(testing::FirstDifference(testing::DumpLocal(kMission, again), local), "");
    EXPECT_EQ(testing::FirstDifference(testing::DumpGlobal(kMission, again), global), "");
    for (uint64_t session = 1; session <= kSessions; ++session) {
      EXPECT_EQ(again.GetLocalMap(kMission, {session})->retired_keyframes,
                street.LocalMap(session).retired_keyframes);
    }
  }
}

TEST(RetiringTest, RobotsAreTold) {
  Street street = Static();
  street.Run(0);
  TestAgent& live = street.Begin(2);
  ASSERT_TRUE(live.Stream().ok());
  street.Fuse();
  ASSERT_TRUE(live.TakeShared().ok());
  const std::map<KeyframeId, SharedKeyframe> before = live.mirror().keyframes;
  street.Run(1);
  const std::vector<KeyframeId> retired = street.Retired(1);
  ASSERT_FALSE(retired.empty());
  EXPECT_TRUE(std::ranges::any_of(retired, [&](KeyframeId id) { return before.contains(id); }));
  ASSERT_TRUE(live.TakeShared().ok());
  for (const KeyframeId& id : retired) EXPECT_FALSE(live.mirror().keyframes.contains(id));
  EXPECT_TRUE(street.Retired(3).empty()) << "its robot is still at work";
}

TEST(RetiringTest, WhatVanishedIsForgotten) {
  std::vector<size_t> gone;
  for (size_t i = 0; i < TheWorld().world.positions_m.size(); i += 7) gone.push_back(i);
  Street street(RetiringOptions(),
                DriveAll(TheWorld().world, testing::Without(TheWorld().world, gone)));
  street.RunAll();
  EXPECT_GT(street.LocalMap(1).faded_points, 10u);
  for (uint64_t session = 2; session <= kSessions; ++session) {
    EXPECT_EQ(street.LocalMap(session).faded_points, 0u);
  }
}

TEST(RetiringTest, OverlapsStillHoldSessionsTogether) {
  Street street = Static();
  street.RunAll();
  const auto accepted = street.store().ListOverlaps(kMission, {true, {}}, {});
  ASSERT_FALSE(accepted->items.empty());
  for (const OverlapInfo& overlap : accepted->items) EXPECT_TRUE(overlap.fused);
  // What people take back is taken back, also where a keyframe of it has gone.
  ASSERT_TRUE(street.store().RetractOverlap(kMission, accepted->items[0].id, false).ok());
  street.Fuse();
  EXPECT_TRUE(*street.store().IsFusionIdle(kMission));
  const std::string global = testing::DumpGlobal(kMission, street.store());
  MapStore again(RetiringOptions(), TheWorld().vocabulary,
                 std::make_unique<ByteJournal>(street.bytes()), nullptr);
  const absl::Status recovered = testing::RecoverUndamaged(again);
  ASSERT_TRUE(recovered.ok()) << recovered;
  EXPECT_EQ(testing::FirstDifference(testing::DumpGlobal(kMission, again), global), "");
}

// A batch that comes after its local map was closed is taken, and what it says of what has gone
// counts no more.
TEST(RetiringTest, ItsOwnerCantBringAKeyframeBack) {
  Street street = Static();
  street.RunAll();
  const std::vector<KeyframeId> retired = street.Retired(1);
  ASSERT_FALSE(retired.empty());
  TestAgent& owner = street.agent(0);
  const Keyframe& gone = *street.drives()[0].map.FindKeyframe(retired[0]);
  MapUpdateBatch late = owner.EmptyBatch();
  late.full_keyframes = {{gone.payload, gone.camera_from_map, gone.parent}};
  late.removed_keyframes = {{retired.back(), {{1}, 0}, {}}};
  const auto seen = std::ranges::find_if(gone.points, [](MapPointId id) { return id.IsValid(); });
  ASSERT_NE(seen, gone.points.end());
  late.observations = {{ObservationChange::Kind::kAdded, *seen, gone.id(),
                        static_cast<uint32_t>(seen - gone.points.begin())}};
  ASSERT_TRUE(owner.Send(late).ok());
  EXPECT_FALSE(street.store().GetKeyframe(kMission, retired[0]).ok());
  EXPECT_EQ(street.LocalMap(1).retired_keyframes, retired.size());
  EXPECT_EQ(street.LocalMap(1).parked_references, 0u);
}

}  // namespace
}  // namespace corbslam::map_store
