// Tests a store whose robot starts again and again at one place: its old sessions become one local
// map, and nobody is the worse for it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

#include "map_store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/map_mirror.h"
#include "map_store/testing/one_robots_store.h"
#include "map_store/testing/recover_whole.h"
#include "map_store/testing/store_dump.h"
#include "map_store/view/map_watcher.h"

namespace corbslam::map_store {
namespace {

using testing::ByteJournal;
using testing::kKeyframesOfDrive;
using testing::kOneRobot;
using testing::kStarts;
using testing::OneRobotsStore;
using testing::TheWorld;

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
  for (const bool from_snapshot : {false, true}) {
    if (from_snapshot) {
      joined.bytes()->wants_snapshot = true;
      ASSERT_TRUE(joined.store().RunFusionUntilIdle("m").ok());
    }
    MapStore again(OneRobotsStore::Options(true), TheWorld().vocabulary,
                   std::make_unique<ByteJournal>(joined.bytes()), nullptr);
    const absl::Status recovered = testing::RecoverWhole(again);
    ASSERT_TRUE(recovered.ok()) << recovered;
    EXPECT_EQ(testing::FirstDifference(testing::DumpLocal("m", again), local), "");
    EXPECT_EQ(testing::FirstDifference(testing::DumpGlobal("m", again), global), "");
  }
}

void Follow(const MapStore& store, MapWatcher watcher, testing::MapMirror& mirror) {
  while (const auto changes = *store.NextChanges("m", 1000, watcher)) mirror.Apply(*changes);
}

// Who comes back knows only up to which version it was told. Islands that it saw may have become
// one, and their local maps parts of others, meanwhile.
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

TEST(JoiningTest, SessionsAreDeletedForGood) {
  OneRobotsStore joined(true);
  joined.StartAll();
  ForgetRequest request{.agent = kOneRobot, .before_ns = {}, .keep = 1, .dry_run = true};
  auto forgotten = joined.store().ForgetLocalMaps("m", request);
  ASSERT_TRUE(forgotten.ok()) << forgotten.status();
  EXPECT_EQ(forgotten->keyframes, 3 * kKeyframesOfDrive);
  EXPECT_EQ(forgotten->parts, 2u);
  EXPECT_EQ(joined.store().GetMission("m")->local_maps, 2u) << "it was a question";
  request.dry_run = false;
  ASSERT_TRUE(joined.store().ForgetLocalMaps("m", request).ok());
  ASSERT_TRUE(joined.store().RunFusionUntilIdle("m").ok());
  EXPECT_EQ(joined.store().GetMission("m")->keyframes, kKeyframesOfDrive);
  EXPECT_FALSE(joined.store().GetKeyframe("m", {{2}, 3}).ok());
  MapStore again(OneRobotsStore::Options(true), TheWorld().vocabulary,
                 std::make_unique<ByteJournal>(joined.bytes()), nullptr);
  const absl::Status recovered = testing::RecoverWhole(again);
  ASSERT_TRUE(recovered.ok()) << recovered;
  EXPECT_EQ(testing::FirstDifference(testing::DumpLocal("m", again),
                                     testing::DumpLocal("m", joined.store())),
            "");
}

}  // namespace
}  // namespace corbslam::map_store
