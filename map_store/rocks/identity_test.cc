// Tests that a mission is told from others of its name: it is deleted while robots stream, and none
// of them makes it anew; its uid outlives restarts, sleep and backups.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/mission_lists.h"
#include "map_store/state/mission_uid.h"
#include "map_store/testing/blank_batch.h"
#include "map_store/testing/rocks_store.h"
#include "slam/exchange/session_end.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::BlankBatch;

class IdentityTest : public testing::RocksStoreTest {
 protected:
  SessionRequest Request(uint64_t instance, const std::string& uid = "") const {
    SessionRequest request;
    request.mission = kMission;
    request.agent = "alpha";
    request.instance = instance;
    request.mission_uid = uid;
    return request;
  }
  // Makes the mission, with one batch in it; returns its uid.
  std::string MakeMission(MapStore& store, uint64_t instance = 1, uint64_t local_map = 1) {
    const auto opened = store.OpenSession(Request(instance));
    EXPECT_TRUE(opened.ok()) << opened.status();
    EXPECT_TRUE(store.Apply(opened->session_id, BlankBatch({local_map}, 1)).ok());
    store.CloseSession(opened->session_id);
    EXPECT_EQ(opened->grant.mission_uid, store.GetMission(kMission)->uid);
    return opened->grant.mission_uid;
  }

  const RocksJournalOptions options_{.directory = Folder("store")};
};

// Streams as a robot does: after each error but the mission's end it opens a session anew.
class StreamingRobot {
 public:
  StreamingRobot(MapStore& store, SessionRequest request, bool knows_uids)
      : store_(store), request_(std::move(request)), knows_uids_(knows_uids) {
    thread_ = std::thread([this] { Run(); });
  }
  ~StreamingRobot() { thread_.join(); }
  // How often it was told that its mission was deleted; it stops then.
  void Join() {
    thread_.join();
    thread_ = std::thread([] {});
  }
  bool heard() const { return heard_; }
  std::string last_error() const { return last_error_; }

 private:
  void Run() {
    uint64_t number = 0;
    const LocalMapId local_map{request_.instance};
    while (!heard_) {
      const auto opened = store_.OpenSession(request_);
      if (!Note(opened.status())) continue;
      if (knows_uids_) request_.mission_uid = opened->grant.mission_uid;
      while (!heard_) {
        const auto kept = store_.Apply(opened->session_id, BlankBatch(local_map, number + 1));
        if (kept.ok()) ++number;
        if (!Note(kept.status())) break;
      }
      store_.CloseSession(opened->session_id);
    }
  }
  bool Note(const absl::Status& status) {
    if (!status.ok()) last_error_ = status.ToString();
    heard_ = SaysMissionDeleted(status);
    return status.ok();
  }

  MapStore& store_;
  SessionRequest request_;
  const bool knows_uids_;
  std::atomic<bool> heard_ = false;
  std::string last_error_;
  std::thread thread_;
};

// CORBSLAM_DELETIONS asks for more.
int NumberOfDeletions() {
  const char* asked = std::getenv("CORBSLAM_DELETIONS");
  return asked == nullptr ? 300 : std::atoi(asked);
}

TEST_F(IdentityTest, AMissionThatIsDeletedWhileRobotsStreamNeverComesBack) {
  const auto store = Open(options_);
  uint64_t instance = 0;
  for (int deletion = 0; deletion < NumberOfDeletions(); ++deletion) {
    std::vector<std::unique_ptr<StreamingRobot>> robots;
    for (int i = 0; i < 3; ++i) {
      SessionRequest request = Request(++instance);
      request.agent = absl::StrCat("r", i);
      robots.push_back(std::make_unique<StreamingRobot>(*store, request, i > 0));
    }
    while (!store->GetMission(kMission).ok() || store->GetMission(kMission)->agents < 3) {
      std::this_thread::yield();
    }
    std::this_thread::sleep_for(std::chrono::microseconds(deletion * 37 % 3000));
    ASSERT_TRUE(store->DeleteMission(kMission).ok());
    for (const auto& robot : robots) robot->Join();
    ASSERT_TRUE(absl::IsNotFound(store->GetMission(kMission).status())) << "deletion " << deletion;
    for (const auto& robot : robots) ASSERT_TRUE(robot->heard()) << robot->last_error();
    ASSERT_FALSE(fs::exists(MissionFolder(options_.directory)));
  }
}

TEST_F(IdentityTest, AMissionOfTheSameNameIsAnotherOne) {
  auto store = Open(options_);
  const std::string first = MakeMission(*store);
  EXPECT_TRUE(IsUidOf(kMission, first)) << first;
  ASSERT_TRUE(store->DeleteMission(kMission).ok());
  EXPECT_TRUE(SaysMissionDeleted(store->OpenSession(Request(1, first)).status()));
  EXPECT_TRUE(SaysMissionDeleted(store->OpenSession(Request(1)).status()))
      << "its process is remembered, though it names no uid";
  EXPECT_TRUE(absl::IsNotFound(store->GetMission(kMission).status()));

  const std::string second = MakeMission(*store, 2, 2);
  EXPECT_NE(second, first);
  EXPECT_TRUE(SaysMissionDeleted(store->OpenSession(Request(1, first)).status()));
  EXPECT_TRUE(SaysMissionDeleted(store->OpenSession(Request(1)).status()));
  EXPECT_TRUE(store->OpenSession(Request(2, second)).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(store->DeleteMission(kMission, first)));
  EXPECT_TRUE(store->GetMission(kMission).ok());
  EXPECT_TRUE(store->DeleteMission(kMission, second).ok());

  // Who deleted what outlives the process.
  store.reset();
  store = Open(options_);
  for (const std::string& uid : {first, second}) {
    EXPECT_TRUE(SaysMissionDeleted(store->OpenSession(Request(3, uid)).status()));
  }
  EXPECT_TRUE(absl::IsNotFound(store->GetMission(kMission).status()));
}

TEST_F(IdentityTest, AUidThatNoStoreDrewForTheNameMakesNoMission) {
  const auto store = Open(options_);
  for (const std::string& uid : {std::string("x"), std::string(32, 'f'), DrawMissionUid("other")}) {
    EXPECT_TRUE(SaysMissionDeleted(store->OpenSession(Request(1, uid)).status())) << uid;
  }
  EXPECT_TRUE(store->ListMissions({})->items.empty());
}

TEST_F(IdentityTest, ARobotThatHasSentNothingYetGoesOnAfterTheStoreWasAway) {
  auto store = Open(options_);
  const std::string uid = store->OpenSession(Request(1))->grant.mission_uid;
  store.reset();
  store = Open(options_);
  const auto again = store->OpenSession(Request(1, uid));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->grant.mission_uid, uid);
}

TEST_F(IdentityTest, WhoeverMakesAMissionAnewOfWhichNothingWasWrittenGivesItTheUidThatIsKnown) {
  auto store = Open(options_);
  const auto first = store->OpenSession(Request(1));
  ASSERT_TRUE(first.ok()) << first.status();
  const std::string uid = first->grant.mission_uid;
  SessionRequest newcomer = Request(2);
  newcomer.agent = "bravo";

  // The mission goes with its last robot, ...
  store->CloseSession(first->session_id);
  ASSERT_TRUE(absl::IsNotFound(store->GetMission(kMission).status()));
  const auto second = store->OpenSession(newcomer);
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(second->grant.mission_uid, uid);
  // ... or with the store's process.
  store.reset();
  store = Open(options_);
  EXPECT_EQ(store->OpenSession(newcomer)->grant.mission_uid, uid);
  EXPECT_TRUE(store->OpenSession(Request(1, uid)).ok());

  ASSERT_TRUE(store->DeleteMission(kMission).ok());
  newcomer.instance = 3;
  EXPECT_NE(store->OpenSession(newcomer)->grant.mission_uid, uid);
  EXPECT_TRUE(SaysMissionDeleted(store->OpenSession(Request(1, uid)).status()));
}

TEST_F(IdentityTest, NoUidIsToldThatWouldNotLast) {
  const auto store = Open(options_);
  fs::create_directories(options_.directory + "/" + FileOfList(MissionList::kPromised));
  const auto refused = store->OpenSession(Request(1));
  EXPECT_TRUE(absl::IsUnavailable(refused.status())) << refused.status();
  EXPECT_THAT(refused.status().message(), ::testing::HasSubstr("PROMISED"));
}

TEST_F(IdentityTest, AUidOutlivesRestartsAndSleepAndCountsAsUnknownWhereAMissionCantBeRead) {
  auto store = Open(options_);
  const std::string uid = MakeMission(*store);
  store.reset();
  store = Open(options_);
  EXPECT_EQ(store->GetMission(kMission)->uid, uid);
  ASSERT_TRUE(store->SleepMission(kMission).ok());
  EXPECT_EQ(store->GetMission(kMission)->uid, uid);
  EXPECT_TRUE(store->OpenSession(Request(1, uid)).ok());
  store.reset();
  for (const auto& entry : fs::directory_iterator(MissionFolder(options_.directory))) {
    if (entry.path().extension() == ".log") fs::remove(entry.path());
  }
  store = Open(options_);
  EXPECT_TRUE(absl::IsDataLoss(store->OpenSession(Request(1, uid)).status()));
  ASSERT_TRUE(store->DeleteMission(kMission).ok());
  EXPECT_TRUE(SaysMissionDeleted(store->OpenSession(Request(1, uid)).status()));
}

TEST_F(IdentityTest, ARestoredMissionGoesOnUnderItsNameAndIsAnotherUnderAnotherOne) {
  const auto store = Open(options_);
  const std::string uid = MakeMission(*store);
  const auto read = [&]() -> absl::StatusOr<MissionState> {
    MissionBackup backup = *store->BackUpMission(kMission);
    MissionRestorer restorer = store->StartRestoring();
    for (std::string piece = backup.Next(1 << 20); !piece.empty(); piece = backup.Next(1 << 20)) {
      EXPECT_TRUE(restorer.Add(piece).ok());
    }
    return restorer.Finish();
  };
  auto state = read();
  auto same = read();
  ASSERT_TRUE(state.ok()) << state.status();
  EXPECT_EQ(state->uid, uid);
  ASSERT_TRUE(store->RestoreMission("copy", *std::move(state)).ok());
  EXPECT_TRUE(IsUidOf("copy", store->GetMission("copy")->uid));
  ASSERT_TRUE(store->DeleteMission(kMission).ok());
  ASSERT_TRUE(store->RestoreMission(kMission, *std::move(same)).ok());
  EXPECT_EQ(store->GetMission(kMission)->uid, uid);
  EXPECT_TRUE(store->OpenSession(Request(1, uid)).ok()) << "its robots go on";
}

TEST_F(IdentityTest, TheFileOfWhatWasDeletedTakesTornLines) {
  const std::string folder = Folder("");
  const MissionIdentity one{"a", DrawMissionUid("a")};
  const MissionIdentity any{"b", ""};
  ASSERT_TRUE(AddToMissionList(folder, MissionList::kDeleted, one).ok());
  std::ofstream(folder + "/" + FileOfList(MissionList::kDeleted), std::ios::app) << "torn 12";
  ASSERT_TRUE(AddToMissionList(folder, MissionList::kDeleted, any).ok());
  EXPECT_THAT(ReadMissionList(folder, MissionList::kDeleted), ::testing::ElementsAre(one, any));
  EXPECT_TRUE(ReadMissionList(Folder("nowhere"), MissionList::kDeleted).empty());
}

}  // namespace
}  // namespace corbslam::map_store
