// Tests a store whose robot starts again and again at one place: its old sessions become one local
// map, and nobody is the worse for it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>

#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/map_mirror.h"
#include "map_store/testing/one_robots_store.h"
#include "map_store/testing/recover_undamaged.h"
#include "map_store/testing/store_dump.h"
#include "map_store/view/map_watcher.h"

namespace corbslam::map_store {
namespace {

using testing::ByteJournal;
using testing::kKeyframesOfDrive;
using testing::kOneRobot;
using testing::kStarts;
using testing::OneRobotsStore;
using testing::TestAgent;
using testing::TheWorld;

// Checks stores that begin with the store's journal, and with its snapshot, without a worker.
void ForEachRestart(OneRobotsStore& joined, const std::function<void(MapStore&)>& check) {
  for (const bool from_snapshot : {false, true}) {
    if (from_snapshot) {
      joined.bytes()->wants_snapshot = true;
      ASSERT_TRUE(joined.store().RunFusionUntilIdle("m").ok());
    }
    MapStore again(OneRobotsStore::Options(true), TheWorld().vocabulary,
                   std::make_unique<ByteJournal>(joined.bytes()), nullptr);
    const absl::Status recovered = testing::RecoverUndamaged(again);
    ASSERT_TRUE(recovered.ok()) << recovered;
    check(again);
  }
}

TEST(JoiningTest, OldSessionsBecomeOneAndFusionGoesOn) {
  OneRobotsStore joined(true);
  joined.StartAll();
  const auto info = joined.store().GetMission("m");
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->local_maps, 2u);
  EXPECT_EQ(info->keyframes, kStarts * kKeyframesOfDrive);
  EXPECT_EQ(joined.store().GetStatistics("m")->islands, 1u) << "the last start was fused, too";
  const auto whole = joined.store().GetLocalMap("m", {3});
  ASSERT_TRUE(whole.ok()) << whole.status();
  EXPECT_EQ(whole->id, LocalMapId{1});
  EXPECT_THAT(whole->joined, ::testing::ElementsAre(LocalMapId{2}, LocalMapId{3}));
  EXPECT_TRUE(joined.store().GetKeyframe("m", {{2}, 3}).ok()) << "ids stay";
}

TEST(JoiningTest, ARestartGivesTheSame) {
  OneRobotsStore joined(true);
  joined.StartAll();
  const std::string local = testing::DumpLocal("m", joined.store());
  const std::string global = testing::DumpGlobal("m", joined.store());
  ForEachRestart(joined, [&](MapStore& again) {
    EXPECT_EQ(testing::FirstDifference(testing::DumpLocal("m", again), local), "");
    EXPECT_EQ(testing::FirstDifference(testing::DumpGlobal("m", again), global), "");
  });
}

void Follow(const MapStore& store, MapWatcher watcher, testing::MapMirror& mirror) {
  while (const auto changes = *store.NextChanges("m", 1000, watcher)) mirror.Apply(*changes);
}

// A robot that comes back knows only up to which version it was told. Islands that it saw may have
// become one, and their local maps parts of others, meanwhile.
TEST(JoiningTest, WhoComesBackIsToldWhichIslandsAreNoMore) {
  OneRobotsStore joined(true);
  joined.Drive(0);
  joined.Drive(1);
  testing::MapMirror mirror(true);
  Follow(joined.store(), MapWatcher(0, true), mirror);
  ASSERT_EQ(joined.store().GlobalMapView("m")->size(), 2u);
  joined.Start(2);
  joined.Start(3);
  ASSERT_EQ(joined.store().GetLocalMap("m", {2})->id, LocalMapId{1});
  Follow(joined.store(), MapWatcher(mirror.version(), true), mirror);
  mirror.ExpectEquals(*joined.store().GlobalMapView("m"));
}

TEST(JoiningTest, WatchersAreToldWhosePartsAre) {
  OneRobotsStore joined(true);
  joined.StartAll();
  MapWatcher watcher(0, false);
  const auto changes = *joined.store().NextChanges("m", 1000, watcher);
  ASSERT_TRUE(changes.has_value());
  ASSERT_EQ(changes->islands.size(), 1u);
  EXPECT_THAT(changes->islands[0].parts,
              ::testing::ElementsAre(::testing::Pair(LocalMapId{2}, kOneRobot),
                                     ::testing::Pair(LocalMapId{3}, kOneRobot)));
}

TEST(JoiningTest, OverlapsOfPartsAreTheWholes) {
  OneRobotsStore joined(true);
  joined.StartAll();
  const LocalMapId newest{4};
  const auto all = joined.store().ListOverlaps("m", {}, {})->items;
  const auto of_whole = std::ranges::count_if(all, [newest](const OverlapInfo& info) {
    return info.overlap.query.local_map != newest || info.overlap.candidate.local_map != newest;
  });
  for (const LocalMapId name : {LocalMapId{1}, LocalMapId{3}}) {
    OverlapFilter filter;
    filter.local_map = name;
    const auto listed = joined.store().ListOverlaps("m", filter, {});
    ASSERT_TRUE(listed.ok()) << listed.status();
    EXPECT_EQ(listed->items.size(), static_cast<size_t>(of_whole)) << ToString(name);
  }
}

TEST(JoiningTest, UnlessToldToEachStaysOne) {
  OneRobotsStore apart(false);
  apart.StartAll();
  EXPECT_EQ(apart.store().GetMission("m")->local_maps, kStarts);
}

TEST(JoiningTest, ABatchForASessionThatIsAPartIsRefused) {
  OneRobotsStore joined(true);
  joined.StartAll();
  const absl::Status status = joined.agent(1).Send(joined.agent(1).EmptyBatch());
  EXPECT_TRUE(absl::IsAborted(status) || absl::IsFailedPrecondition(status)) << status;
}

// A store with --keep-local-maps 0, and a robot that stays connected: its first session is closed,
// and its second one becomes a part of that as soon as it is closed.
class JoinedAtOnceTest : public ::testing::Test {
 protected:
  JoinedAtOnceTest() {
    joined_.Start(0);
    robot_ = std::make_unique<TestAgent>(joined_.store(), "m", kOneRobot, joined_.drives()[1]);
    EXPECT_TRUE(robot_->Stream().ok());
    EXPECT_TRUE(robot_->TakeShared().ok());
    Fuse();
    EXPECT_TRUE(robot_->TakeShared().ok());
    EXPECT_FALSE(robot_->mirror().own.empty());
    EXPECT_TRUE(robot_->Close().ok());
    Fuse();
    EXPECT_EQ(joined_.store().GetLocalMap("m", {2})->id, LocalMapId{1});
  }

  static MapStoreOptions Options() {
    MapStoreOptions options = OneRobotsStore::Options(true);
    options.keep_local_maps = 0;
    return options;
  }
  void Fuse() { ASSERT_TRUE(joined_.store().RunFusionUntilIdle("m").ok()); }
  AgentInfo Described() { return joined_.store().ListAgents("m", {})->items.at(0); }

  OneRobotsStore joined_{Options(), std::make_shared<testing::JournalBytes>()};
  std::unique_ptr<TestAgent> robot_;
};

TEST_F(JoinedAtOnceTest, TheWholesPlaceIsNotToldAsTheRobotsOwn) {
  const int updates = robot_->mirror().updates;
  ASSERT_TRUE(robot_->TakeShared().ok());
  EXPECT_EQ(robot_->mirror().updates, updates);
  EXPECT_FALSE(robot_->mirror().global_from_local.has_value());
  EXPECT_TRUE(Described().up_to_date) << "there is nothing to tell";
  // It goes on in a new local map, of which the store has nothing yet.
  TestAgent next(joined_.store(), "m", kOneRobot, joined_.drives()[2]);
  ASSERT_TRUE(next.TakeShared().ok());
  EXPECT_EQ(next.mirror().updates, 0);
  ASSERT_TRUE(next.Stream().ok());
  Fuse();
  ASSERT_TRUE(next.TakeShared().ok());
  EXPECT_FALSE(next.mirror().own.empty());
  for (const auto& [id, pose] : next.mirror().own) EXPECT_EQ(id.local_map, LocalMapId{3});
  EXPECT_FALSE(next.mirror().keyframes.empty()) << "its earlier sessions are as others' now";
  EXPECT_TRUE(Described().up_to_date);
}

TEST_F(JoinedAtOnceTest, WhatComesLaterRefersToThePart) {
  TestAgent next(joined_.store(), "m", kOneRobot, joined_.drives()[2]);
  MapUpdateBatch batch = next.NextBatch(2);
  // The newest keyframe sees a point of the session before, and a frame is told against it.
  batch.observations.back().point = joined_.drives()[1].map.points().begin()->first;
  const int64_t later_ns = batch.tracked_frames.back().timestamp_ns + 1;
  batch.tracked_frames.push_back({later_ns, robot_->Id(4), Rigid3d::Identity()});
  ASSERT_TRUE(next.Send(batch).ok());
  const auto info = joined_.store().GetLocalMap("m", {3});
  EXPECT_EQ(info->parked_references, 0u) << "what it refers to is there";
  EXPECT_EQ(info->tracked_frames, 3u);
  EXPECT_EQ(Described().last_pose->timestamp_ns, later_ns - 1)
      << "the frame refers to another island as yet";
}

TEST_F(JoinedAtOnceTest, WhoResumesIsAcknowledgedAndBeginsANewOne) {
  SessionRequest request;
  request.mission = "m";
  request.agent = kOneRobot;
  request.local_maps = {LocalMapId{1}, LocalMapId{2}, LocalMapId{3}};
  const auto opened = joined_.store().OpenSession(request);
  ASSERT_TRUE(opened.ok()) << opened.status();
  const auto& acknowledged = opened->grant.acknowledged;
  ASSERT_EQ(acknowledged.size(), 3u);
  EXPECT_EQ(acknowledged[0].number, kKeyframesOfDrive + 1);
  EXPECT_EQ(acknowledged[1].number, kKeyframesOfDrive + 1);
  EXPECT_EQ(acknowledged[2].number, 0u);
  for (const LocalMapId gone : {LocalMapId{1}, LocalMapId{2}}) {
    MapUpdateBatch batch;
    batch.local_map = gone;
    batch.number = kKeyframesOfDrive + 1;
    EXPECT_TRUE(joined_.store().Apply(opened->session_id, batch).ok()) << "it came again";
    ++batch.number;
    const absl::Status status = joined_.store().Apply(opened->session_id, batch).status();
    EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
    EXPECT_THAT(std::string(status.message()), ::testing::HasSubstr("begin a new local map"));
  }
}

TEST_F(JoinedAtOnceTest, ARestartGivesTheSame) {
  TestAgent next(joined_.store(), "m", kOneRobot, joined_.drives()[2]);
  ASSERT_TRUE(next.Stream().ok());
  ASSERT_TRUE(next.Close().ok());
  Fuse();
  ASSERT_EQ(joined_.store().GetLocalMap("m", {3})->id, LocalMapId{1});
  const auto last_pose = Described().last_pose;
  ASSERT_TRUE(last_pose.has_value());
  for (const bool from_snapshot : {false, true}) {
    if (from_snapshot) {
      joined_.bytes()->wants_snapshot = true;
      Fuse();
    }
    MapStore again(Options(), TheWorld().vocabulary, std::make_unique<ByteJournal>(joined_.bytes()),
                   nullptr);
    const absl::Status recovered = testing::RecoverUndamaged(again);
    ASSERT_TRUE(recovered.ok()) << recovered;
    EXPECT_EQ(testing::FirstDifference(testing::DumpGlobal("m", again),
                                       testing::DumpGlobal("m", joined_.store())),
              "");
    const auto of_again = again.ListAgents("m", {})->items.at(0).last_pose;
    ASSERT_TRUE(of_again.has_value());
    EXPECT_EQ(of_again->timestamp_ns, last_pose->timestamp_ns);
  }
}

TEST(JoiningTest, SessionsAreDeletedForGood) {
  OneRobotsStore joined(true);
  joined.StartAll();
  ForgetRequest request{.agent = kOneRobot, .before_ns = {}, .keep = 1, .dry_run = true};
  auto forgotten = joined.store().ForgetLocalMaps("m", request);
  ASSERT_TRUE(forgotten.ok()) << forgotten.status();
  EXPECT_EQ(forgotten->keyframes, 3 * kKeyframesOfDrive);
  EXPECT_EQ(forgotten->parts, 2u);
  EXPECT_THAT(forgotten->numbers, ::testing::ElementsAre(1, 2, 3));
  EXPECT_EQ(joined.store().GetMission("m")->local_maps, 2u) << "it was a question";
  request.dry_run = false;
  ASSERT_TRUE(joined.store().ForgetLocalMaps("m", request).ok());
  ASSERT_TRUE(joined.store().RunFusionUntilIdle("m").ok());
  EXPECT_EQ(joined.store().GetMission("m")->keyframes, kKeyframesOfDrive);
  EXPECT_FALSE(joined.store().GetKeyframe("m", {{2}, 3}).ok());
  MapStore again(OneRobotsStore::Options(true), TheWorld().vocabulary,
                 std::make_unique<ByteJournal>(joined.bytes()), nullptr);
  const absl::Status recovered = testing::RecoverUndamaged(again);
  ASSERT_TRUE(recovered.ok()) << recovered;
  EXPECT_EQ(testing::FirstDifference(testing::DumpLocal("m", again),
                                     testing::DumpLocal("m", joined.store())),
            "");
}

// The numbers are those by which people call local maps, and files that were exported once.
TEST(JoiningTest, NumbersStayWhateverBecomesOfTheSessions) {
  OneRobotsStore joined(true);
  joined.StartAll();
  const auto whole = joined.store().GetLocalMap("m", {1});
  ASSERT_TRUE(whole.ok()) << whole.status();
  EXPECT_EQ(whole->number, 1u);
  EXPECT_THAT(whole->joined_numbers, ::testing::ElementsAre(2, 3));
  EXPECT_EQ(joined.store().GetLocalMap("m", {4})->number, 4u);
  ForgetRequest request{.agent = kOneRobot, .before_ns = {}, .keep = 1};
  ASSERT_TRUE(joined.store().ForgetLocalMaps("m", request).ok());
  EXPECT_EQ(joined.store().GetLocalMap("m", {4})->number, 4u);
  ASSERT_TRUE(joined.store().RunFusionUntilIdle("m").ok());
  request.keep = 0;
  ASSERT_TRUE(joined.store().ForgetLocalMaps("m", request).ok());
  const testing::SyntheticMap drive = testing::MakeRingMap(5, 5, 2);
  ForEachRestart(joined, [&](MapStore& again) {
    TestAgent next(again, "m", kOneRobot, drive);
    ASSERT_TRUE(next.Send(next.NextBatch(1)).ok());
    EXPECT_EQ(again.GetLocalMap("m", {5})->number, 5u) << "none is given twice";
  });
}

}  // namespace
}  // namespace corbslam::map_store
