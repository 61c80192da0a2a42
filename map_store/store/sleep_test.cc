// Tests that missions leave memory when nobody uses them, and come back as they were.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_split.h"
#include "absl/synchronization/notification.h"
#include "map_store/mission/mission_load.h"
#include "map_store/store/journal_check.h"
#include "map_store/testing/one_robots_store.h"
#include "map_store/testing/sleeping_store.h"
#include "map_store/testing/store_dump.h"
#include "map_store/view/asleep_error.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DumpGlobal;
using testing::DumpLocal;
using testing::FirstDifference;
using ::testing::HasSubstr;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TruthfulWorker;

class SleepTest : public testing::SleepingStore {
 protected:
  void FallAsleep(const std::string& mission = kMission) {
    const absl::Status status = store_->SleepMission(mission);
    ASSERT_TRUE(status.ok()) << status;
    ASSERT_TRUE(IsAsleep(mission));
  }
  std::string WhyAwake(const std::string& mission = kMission) {
    const absl::Status status = store_->SleepMission(mission);
    EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
    return std::string(status.message());
  }
  // Fuses two robots' maps in one mission.
  void FuseTwo() {
    worker_ = &truthful_;
    Open();
    TestAgent a(*store_, kMission, "a", map_a_);
    TestAgent b(*store_, kMission, "b", map_b_);
    for (TestAgent* robot : {&a, &b}) {
      ASSERT_TRUE(robot->Stream().ok());
      ASSERT_TRUE(robot->Close().ok());
      store_->CloseSession(robot->session());
    }
    ASSERT_TRUE(store_->RunFusionUntilIdle(kMission).ok());
  }
  bool ChecksOut() {
    store_.reset();
    bool whole = true;
    const absl::Status checked =
        CheckJournal(folder_.string(), [&whole](const CheckedMission& mission) {
          EXPECT_TRUE(mission.status.ok()) << mission.status;
          whole = whole && mission.status.ok();
        });
    EXPECT_TRUE(checked.ok()) << checked;
    return whole;
  }
};

TEST_F(SleepTest, FallsAsleepWhenItsTimeHasComeAndWakesAsItWas) {
  Fill(kMission, map_a_);
  const std::string local = DumpLocal(kMission, *store_);
  const std::string global = DumpGlobal(kMission, *store_);
  const MissionInfo awake = *store_->GetMission(kMission);
  now_ += absl::Seconds(599);
  EXPECT_EQ(store_->SleepUnused(), 0u);
  now_ += absl::Seconds(1);
  EXPECT_EQ(store_->SleepUnused(), 1u);
  const int reads = counts_.reads_with_features;
  const MissionInfo asleep = *store_->GetMission(kMission);
  EXPECT_TRUE(asleep.asleep);
  EXPECT_FALSE(awake.asleep);
  EXPECT_EQ(asleep.keyframes, awake.keyframes);
  EXPECT_EQ(asleep.map_points, awake.map_points);
  EXPECT_EQ(asleep.agents, 1u);
  EXPECT_EQ(asleep.profile.last_used_ns, awake.profile.last_used_ns) << "who only looks is no user";
  EXPECT_GT(asleep.disk_bytes, 0u);
  ASSERT_EQ(store_->ListMissions({})->items.size(), 1u);
  EXPECT_TRUE(store_->ListMissions({})->items[0].asleep);
  ASSERT_EQ(store_->ListLoads().size(), 1u);
  EXPECT_EQ(store_->ListLoads()[0].keyframes, awake.keyframes);
  EXPECT_EQ(store_->ListLoads()[0].memory_bytes, 0u);
  EXPECT_EQ(store_->sleep().asleep, 1u);
  EXPECT_EQ(counts_.reads_with_features, reads) << "nothing of that reads the mission";
  EXPECT_EQ(FirstDifference(DumpLocal(kMission, *store_), local), "");
  EXPECT_EQ(FirstDifference(DumpGlobal(kMission, *store_), global), "");
  EXPECT_EQ(counts_.reads_with_features, reads + 1);
  EXPECT_EQ(store_->sleep().woken, 1u);
  EXPECT_FALSE(IsAsleep());
  EXPECT_EQ(store_->SleepUnused(), 0u) << "it was used a moment ago";
}

TEST_F(SleepTest, ARobotGoesOnInAMissionThatSlept) {
  TestAgent robot(*store_, kMission, "robot", map_a_);
  ASSERT_TRUE(robot.Stream(4).ok());
  store_->CloseSession(robot.session());
  FallAsleep();
  SessionRequest request;
  request.mission = kMission;
  request.agent = "robot";
  request.local_maps = {robot.local_map()};
  const auto opened = store_->OpenSession(request);
  ASSERT_TRUE(opened.ok()) << opened.status();
  ASSERT_EQ(opened->grant.acknowledged.size(), 1u);
  EXPECT_EQ(opened->grant.acknowledged[0].number, 4u);
  ASSERT_TRUE(store_->Apply(opened->session_id, robot.NextBatch(1)).ok());
  EXPECT_EQ(store_->GetMission(kMission)->keyframes, 5u);
  EXPECT_THAT(WhyAwake(), HasSubstr("robots are connected"));
  store_->CloseSession(opened->session_id);
  FallAsleep();
  EXPECT_EQ(store_->ListKeyframes(kMission, {}, {})->items.size(), 5u);
}

TEST_F(SleepTest, WhoWatchesKeepsItAwake) {
  Fill(kMission, map_a_);
  const auto map = store_->AddMapListener(kMission, [] {});
  EXPECT_THAT(WhyAwake(), HasSubstr("somebody watches"));
  store_->RemoveMapListener(kMission, *map);
  const auto events = store_->AddEventListener(kMission, [] {});
  EXPECT_THAT(WhyAwake(), HasSubstr("somebody watches"));
  now_ += absl::Hours(1);
  EXPECT_EQ(store_->SleepUnused(), 0u);
  store_->RemoveEventListener(kMission, *events);
  EXPECT_EQ(store_->SleepUnused(), 0u) << "its watcher has just left";
  now_ += absl::Hours(1);
  EXPECT_EQ(store_->SleepUnused(), 1u);
  EXPECT_TRUE(absl::IsNotFound(store_->SleepMission("nowhere")));
  EXPECT_TRUE(store_->SleepMission(kMission).ok()) << "it sleeps already";
}

TEST_F(SleepTest, WithoutAJournalNothingSleeps) {
  store_ =
      std::make_unique<MapStore>(options_, nullptr, std::make_unique<InMemoryJournal>(), nullptr);
  Fill(kMission, map_a_);
  EXPECT_THAT(WhyAwake(), HasSubstr("--data-dir"));
}

TEST_F(SleepTest, RemembersItsLatestEvents) {
  Fill(kMission, map_a_);
  const auto first = store_->EventAfter(kMission, 0);
  ASSERT_TRUE(first.ok() && first->has_value());
  FallAsleep();
  const auto again = store_->EventAfter(kMission, 0);
  ASSERT_TRUE(again.ok() && again->has_value());
  EXPECT_EQ((*again)->number, (*first)->number);
  EXPECT_EQ((*again)->time, (*first)->time);
}

// What no record says must not be decided again: workers would look at it once more.
TEST_F(SleepTest, KeepsWhatRecordsDoNotSay) {
  ASSERT_NO_FATAL_FAILURE(FuseTwo());
  const std::string global = DumpGlobal(kMission, *store_);
  const uint64_t queried = store_->GetStatistics(kMission)->overlaps_queried;
  const size_t asked = truthful_.asked().size();
  EXPECT_GT(queried, 0u);
  FallAsleep();
  EXPECT_EQ(FirstDifference(DumpGlobal(kMission, *store_), global), "");
  EXPECT_EQ(store_->GetStatistics(kMission)->overlaps_queried, queried);
  EXPECT_TRUE(*store_->IsFusionIdle(kMission));
  ASSERT_TRUE(store_->RunFusionUntilIdle(kMission).ok());
  EXPECT_EQ(truthful_.asked().size(), asked);
}

// The second time there are no new records: the snapshot takes the place of one at its own
// position.
TEST_F(SleepTest, WritesASnapshotOnlyForWhatHasChanged) {
  Fill(kMission, map_a_);
  FallAsleep();
  EXPECT_EQ(counts_.snapshots, 1);
  const std::string local = DumpLocal(kMission, *store_);
  FallAsleep();
  EXPECT_EQ(counts_.snapshots, 1) << "it was only looked at";
  SessionRequest request;
  request.mission = kMission;
  request.agent = "newcomer";
  store_->CloseSession(store_->OpenSession(request)->session_id);
  FallAsleep();
  EXPECT_EQ(counts_.snapshots, 2);
  EXPECT_EQ(store_->ListAgents(kMission, {})->items.size(), 2u) << "the newcomer is remembered";
  EXPECT_EQ(FirstDifference(DumpLocal(kMission, *store_), local), "");
  EXPECT_TRUE(ChecksOut());
}

TEST_F(SleepTest, ManyCallersReadItOnce) {
  options_.deterministic = false;
  Open();
  Fill(kMission, map_a_);
  FallAsleep();
  const int reads = counts_.reads_with_features;
  std::vector<std::thread> callers;
  for (int i = 0; i < 10; ++i) {
    callers.emplace_back([this] { EXPECT_EQ(store_->ListAgents(kMission, {})->items.size(), 1u); });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(counts_.reads_with_features, reads + 1);
}

TEST_F(SleepTest, NobodyElseWaitsWhileOneIsRead) {
  options_.deterministic = false;
  Open();
  Fill(kMission, map_a_);
  Fill("other", map_b_);
  FallAsleep();
  absl::Notification reading;
  absl::Notification go_on;
  counts_.on_read = [&](const std::string&) {
    reading.Notify();
    go_on.WaitForNotification();
  };
  std::thread caller([this] { EXPECT_TRUE(store_->ListAgents(kMission, {}).ok()); });
  reading.WaitForNotification();
  EXPECT_EQ(store_->ListAgents("other", {})->items.size(), 1u);
  TestAgent robot(*store_, "third", "robot", map_a_);
  EXPECT_TRUE(robot.Stream(2).ok());
  EXPECT_TRUE(IsAsleep()) << "it is not there before it is read";
  go_on.Notify();
  caller.join();
  EXPECT_FALSE(IsAsleep());
}

TEST_F(SleepTest, ACallerThatCanNotWaitIsCalled) {
  options_.deterministic = false;
  options_.wake_in_background = true;
  Open();
  Fill(kMission, map_a_);
  FallAsleep();
  const absl::Status asleep = store_->ListAgents(kMission, {}).status();
  EXPECT_TRUE(absl::IsUnavailable(asleep)) << asleep;
  EXPECT_EQ(AsleepMission(asleep), kMission);
  SessionRequest request;
  request.mission = kMission;
  request.agent = "robot";
  EXPECT_EQ(AsleepMission(store_->OpenSession(request).status()), kMission);
  absl::Notification awake;
  std::shared_ptr<const void> held;
  ASSERT_TRUE(store_
                  ->WhenAwake(kMission,
                              [&](const auto& ready) {
                                EXPECT_TRUE(ready.ok()) << ready.status();
                                if (ready.ok()) held = *ready;
                                awake.Notify();
                              })
                  .ok());
  awake.WaitForNotification();
  EXPECT_TRUE(store_->ListAgents(kMission, {}).ok());
  EXPECT_THAT(WhyAwake(), HasSubstr("calls are under way")) << "it is held";
  held.reset();
  absl::Notification refused;
  ASSERT_TRUE(store_
                  ->WhenAwake("nowhere",
                              [&](const auto& ready) {
                                EXPECT_TRUE(absl::IsNotFound(ready.status())) << ready.status();
                                refused.Notify();
                              })
                  .ok());
  refused.WaitForNotification();
}

TEST_F(SleepTest, DamageIsFoundWhenItWakes) {
  Fill(kMission, map_a_);
  Fill("other", map_b_);
  FallAsleep();
  for (const auto& entry : fs::directory_iterator(FolderOf())) {
    if (entry.path().extension() == ".sst") fs::resize_file(entry.path(), 10);
  }
  EXPECT_TRUE(store_->ListDamaged().empty()) << "nobody has looked";
  for (int i = 0; i < 2; ++i) {
    const absl::Status damaged = store_->ListAgents(kMission, {}).status();
    EXPECT_TRUE(absl::IsDataLoss(damaged)) << damaged;
    EXPECT_THAT(std::string(damaged.message()), HasSubstr("corbslam mission restore"));
  }
  EXPECT_NE(store_->GetMission(kMission)->damage, "");
  EXPECT_EQ(store_->ListDamaged().size(), 1u);
  EXPECT_TRUE(store_->ListAgents("other", {}).ok());
  EXPECT_TRUE(store_->DeleteMission(kMission).ok());
  EXPECT_TRUE(absl::IsNotFound(store_->GetMission(kMission).status()));
}

TEST_F(SleepTest, IsDeletedWithoutBeingRead) {
  Fill(kMission, map_a_);
  FallAsleep();
  const int reads = counts_.reads_with_features;
  EXPECT_TRUE(store_->DeleteMission(kMission).ok());
  EXPECT_EQ(counts_.reads_with_features, reads);
  EXPECT_FALSE(fs::exists(FolderOf()));
  EXPECT_TRUE(absl::IsNotFound(store_->ListAgents(kMission, {}).status()));
  Fill(kMission, map_b_);
  EXPECT_EQ(store_->GetMission(kMission)->keyframes, 14u) << "the name is free again";
}

TEST_F(SleepTest, ItsRetentionPassesWithoutItsBeingRead) {
  Fill(kMission, map_a_);
  MissionProfile values;
  values.retention_s = 36'000;
  ASSERT_TRUE(store_->UpdateMission(kMission, values, {ProfileField::kRetention}).ok());
  FallAsleep();
  const int reads = counts_.reads_with_features;
  now_ += absl::Hours(11) - absl::Seconds(1);
  store_->TendMissions();
  EXPECT_TRUE(IsAsleep());
  now_ += absl::Seconds(1);
  store_->TendMissions();
  EXPECT_TRUE(absl::IsNotFound(store_->GetMission(kMission).status()));
  EXPECT_EQ(counts_.reads_with_features, reads);
}

TEST_F(SleepTest, IsBackedUpAndRestored) {
  ASSERT_NO_FATAL_FAILURE(FuseTwo());
  const std::string local = DumpLocal(kMission, *store_);
  FallAsleep();
  auto backup = store_->BackUpMission(kMission);
  ASSERT_TRUE(backup.ok()) << backup.status();
  MissionRestorer restorer = store_->StartRestoring();
  for (std::string piece = backup->Next(1 << 20); !piece.empty(); piece = backup->Next(1 << 20)) {
    ASSERT_TRUE(restorer.Add(piece).ok());
  }
  auto state = restorer.Finish();
  ASSERT_TRUE(state.ok()) << state.status();
  FallAsleep();
  EXPECT_TRUE(absl::IsAlreadyExists(store_->RestoreMission(kMission, *state)));
  ASSERT_TRUE(store_->RestoreMission("copy", *std::move(state)).ok());
  // No record was written since it was restored.
  ASSERT_TRUE(store_->RunFusionUntilIdle("copy").ok());
  const std::string global = DumpGlobal("copy", *store_);
  SessionRequest request;
  request.mission = "copy";
  request.agent = "newcomer";
  store_->CloseSession(store_->OpenSession(request)->session_id);
  ASSERT_NO_FATAL_FAILURE(FallAsleep("copy"));
  EXPECT_EQ(FirstDifference(DumpLocal("copy", *store_), local), "");
  EXPECT_EQ(FirstDifference(DumpGlobal("copy", *store_), global), "");
  EXPECT_EQ(store_->ListAgents("copy", {})->items.size(), 3u);
  EXPECT_TRUE(ChecksOut());
}

TEST_F(SleepTest, MakesRoomForOneMoreMission) {
  options_.max_missions = 2;
  Open();
  Fill("first", map_a_);
  now_ += absl::Seconds(1);
  Fill("second", map_a_);
  now_ += absl::Seconds(1);
  Fill("third", map_a_);
  EXPECT_TRUE(IsAsleep("first")) << "it has not been used for longest";
  EXPECT_FALSE(IsAsleep("second"));
  // Both are used: nobody else can come in.
  TestAgent a(*store_, "second", "a", map_b_);
  TestAgent b(*store_, "third", "b", map_b_);
  const absl::Status full = store_->ListAgents("first", {}).status();
  EXPECT_TRUE(absl::IsResourceExhausted(full)) << full;
  EXPECT_TRUE(IsAsleep("first"));
  store_->CloseSession(a.session());
  EXPECT_TRUE(store_->ListAgents("first", {}).ok());
  EXPECT_TRUE(IsAsleep("second"));
}

TEST_F(SleepTest, WithoutMemoryIdleMissionsSleepAndNoneWakes) {
  Fill("first", map_a_);
  Fill("second", map_a_);
  options_.sleep_after_s = 0;
  Open();
  EXPECT_EQ(store_->sleep().asleep, 0u);
  options_.sleep_after_s = 600;
  options_.memory_budget_bytes = 1 << 20;
  Open();
  EXPECT_EQ(store_->sleep().asleep, 2u);
  const absl::Status refused = store_->ListAgents("first", {}).status();
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_TRUE(IsAsleep("first"));
}

// A mission whose robot started twice, and whose sessions became one.
class JoinedMissionTest : public SleepTest {
 protected:
  JoinedMissionTest() {
    options_.join_local_maps = true;
    options_.keep_local_maps = 0;
    worker_ = &truthful_;
    Open();
    Fill(kMission, map_a_);
    Fill(kMission, map_b_);
    EXPECT_TRUE(store_->RunFusionUntilIdle(kMission).ok());
    local_ = DumpLocal(kMission, *store_);
    global_ = DumpGlobal(kMission, *store_);
  }
  void ExpectJoined(const std::string& mission) {
    const auto whole = store_->GetLocalMap(mission, {0xb});
    ASSERT_TRUE(whole.ok()) << whole.status();
    EXPECT_EQ(whole->id, LocalMapId{0xa});
    EXPECT_THAT(whole->joined, ::testing::ElementsAre(LocalMapId{0xb}));
    EXPECT_EQ(store_->GetMission(mission)->local_maps, 1u);
  }
  void ExpectTheSame() {
    ExpectJoined(kMission);
    EXPECT_EQ(FirstDifference(DumpLocal(kMission, *store_), local_), "");
    EXPECT_EQ(FirstDifference(DumpGlobal(kMission, *store_), global_), "");
  }

  std::string local_;
  std::string global_;
};

TEST_F(JoinedMissionTest, SleepsAndWakesAsItWas) {
  ASSERT_NO_FATAL_FAILURE(ExpectJoined(kMission));
  FallAsleep();
  EXPECT_EQ(store_->GetMission(kMission)->local_maps, 1u);
  ExpectTheSame();
  FallAsleep();
  Open();
  EXPECT_TRUE(IsAsleep());
  ExpectTheSame();
  EXPECT_TRUE(*store_->IsFusionIdle(kMission)) << "nothing is left to become one";
  EXPECT_TRUE(ChecksOut());
}

// Lists go by when local maps came, and what became a part comes with its whole after a restart.
std::vector<std::string> SortedLines(const std::string& dump) {
  std::vector<std::string> lines = absl::StrSplit(dump, '\n');
  std::ranges::sort(lines);
  return lines;
}

// Another robot's session came between two that become one: keyframes of the whole have names on
// both sides of it. A snapshot gives back what it doesn't need, and must know what it does.
TEST_F(SleepTest, ASnapshotAfterJoiningKeepsAllFeatures) {
  const std::vector<SyntheticMap> drives = testing::MakeDrives();
  TruthfulWorker worker({&drives[0], &drives[1], &drives[2]});
  options_.join_local_maps = true;
  options_.keep_local_maps = 0;
  worker_ = &worker;
  Open();
  for (const size_t drive : {0, 1, 2}) {
    TestAgent robot(*store_, kMission, drive == 1 ? "other" : "robot", drives[drive]);
    ASSERT_TRUE(robot.Stream().ok());
    ASSERT_TRUE(robot.Close().ok());
    store_->CloseSession(robot.session());
  }
  ASSERT_TRUE(store_->RunFusionUntilIdle(kMission).ok());
  ASSERT_EQ(store_->GetLocalMap(kMission, {3})->id, LocalMapId{1}) << "3 became a part of 1";
  const std::vector<std::string> local = SortedLines(DumpLocal(kMission, *store_));
  FallAsleep();
  EXPECT_EQ(SortedLines(DumpLocal(kMission, *store_)), local);
  EXPECT_TRUE(ChecksOut());
  Open();
}

TEST_F(JoinedMissionTest, IsBackedUpAndRestored) {
  MissionBackup backup = *store_->BackUpMission(kMission);
  MissionRestorer restorer = store_->StartRestoring();
  for (std::string piece = backup.Next(1 << 20); !piece.empty(); piece = backup.Next(1 << 20)) {
    ASSERT_TRUE(restorer.Add(piece).ok());
  }
  absl::StatusOr<MissionState> state = restorer.Finish();
  ASSERT_TRUE(state.ok()) << state.status();
  ASSERT_TRUE(store_->DeleteMission(kMission).ok());
  ASSERT_TRUE(store_->RestoreMission(kMission, *std::move(state)).ok());
  ExpectTheSame();
  // Its robot comes back to the part that it knows, and is told what the store has of it.
  SessionRequest request;
  request.mission = kMission;
  request.agent = "robot";
  request.local_maps = {{0xb}};
  const auto session = store_->OpenSession(request);
  ASSERT_TRUE(session.ok()) << session.status();
  ASSERT_EQ(session->grant.acknowledged.size(), 1u);
  EXPECT_GT(session->grant.acknowledged[0].number, 0u);
  Open();
  ExpectJoined(kMission);
}

}  // namespace
}  // namespace corbslam::map_store
