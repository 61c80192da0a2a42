// Tests backups that a store keeps beside its journal, down to their files.
#include "map_store/store/stored_backups.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/backup_folder.h"
#include "map_store/testing/journal_room.h"
#include "map_store/testing/store_dump.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DumpGlobal;
using testing::DumpLocal;
using ::testing::HasSubstr;

class StoredBackupsTest : public testing::JournalRoom {
 protected:
  StoredBackupsTest() { OpenBoth(); }
  ~StoredBackupsTest() override { backups_.reset(); }

  void OpenBoth(size_t keep = 24) {
    backups_.reset();
    Open();
    BackupOptions options;
    options.directory = Shelf();
    options.bytes_per_s = 0;
    options.free_bytes = [this](const std::string&) { return free_bytes_; };
    auto folder = BackupFolder::Open(journal_, options);
    ASSERT_TRUE(folder.ok()) << folder.status();
    backups_ = std::make_unique<StoredBackups>(store_.get(), *std::move(folder), keep,
                                               [this] { return now_; });
  }
  std::string Shelf() const { return Folder("backups"); }

  uint32_t Store(const std::string& mission) {
    now_ += absl::Minutes(10);
    const absl::StatusOr<StoredBackup> made = backups_->Store(mission);
    EXPECT_TRUE(made.ok()) << made.status();
    return made.ok() ? made->number : 0;
  }
  std::vector<uint32_t> Numbers(const std::string& mission) const {
    std::vector<uint32_t> numbers;
    const auto page = backups_->List(mission, {.page_size = 1000, .page_token = ""});
    EXPECT_TRUE(page.ok()) << page.status();
    for (const StoredBackup& backup : page->items) numbers.push_back(backup.number);
    return numbers;
  }
  // Returns the largest file that holds a table or features of the mission's backups.
  fs::path LargestShared(const std::string& mission) const {
    fs::path largest;
    uint64_t size = 0;
    for (const auto& entry :
         fs::directory_iterator(fs::path(Shelf()) / mission / "shared_checksum")) {
      if (entry.file_size() <= size) continue;
      size = entry.file_size();
      largest = entry.path();
    }
    return largest;
  }

  absl::Time now_ = absl::FromUnixSeconds(1'800'000'000);
  uint64_t free_bytes_ = uint64_t{1} << 40;
  std::unique_ptr<StoredBackups> backups_;
};

TEST_F(StoredBackupsTest, EachIsTheMissionAsItWasAndRestoresUnderAnyName) {
  Stream("m", 6);
  const std::string first = DumpLocal("m", *store_);
  ASSERT_EQ(Store("m"), 1u);
  Stream("m", 4);
  const std::string second = DumpLocal("m", *store_);
  const std::string global = DumpGlobal("m", *store_);
  ASSERT_EQ(Store("m"), 2u);
  ASSERT_TRUE(backups_->Restore("m", 1, "then").ok());
  const absl::Status restored = backups_->Restore("m", 2, "later");
  ASSERT_TRUE(restored.ok()) << restored;
  EXPECT_EQ(DumpLocal("then", *store_), first);
  EXPECT_EQ(DumpLocal("later", *store_), second);
  EXPECT_EQ(DumpGlobal("later", *store_), global);
  EXPECT_TRUE(absl::IsAlreadyExists(backups_->Restore("m", 1, "then")));
  EXPECT_TRUE(absl::IsAlreadyExists(backups_->Restore("m", 1, "m")));
  EXPECT_TRUE(absl::IsInvalidArgument(backups_->Restore("m", 1, "a/b")));
  EXPECT_TRUE(absl::IsNotFound(backups_->Restore("m", 9, "x")));
  EXPECT_TRUE(absl::IsNotFound(backups_->Restore("nobody", 1, "x")));
  // What was restored lasts, and has backups of its own.
  OpenBoth();
  EXPECT_EQ(DumpLocal("then", *store_), first);
  EXPECT_EQ(Store("then"), 1u);
}

TEST_F(StoredBackupsTest, SaysWhatItHoldsAndSharesFiles) {
  Stream("m", 12);
  ASSERT_EQ(Store("m"), 1u);
  const uint64_t one = BytesIn(Shelf());
  Stream("m", 1);
  ASSERT_EQ(Store("m"), 2u);
  EXPECT_LT(BytesIn(Shelf()), one + one / 2) << "the second has the first one's tables";
  const auto page = backups_->List("", {.page_size = 1, .page_token = ""});
  ASSERT_TRUE(page.ok()) << page.status();
  ASSERT_EQ(page->items.size(), 1u);
  EXPECT_EQ(page->items[0].mission, "m");
  EXPECT_EQ(page->items[0].facts.keyframes, 12u);
  EXPECT_GT(page->items[0].bytes, 10000u);
  EXPECT_FALSE(page->items[0].facts.archived);
  const auto rest = backups_->List("", {.page_size = 5, .page_token = page->next_page_token});
  ASSERT_TRUE(rest.ok()) << rest.status();
  ASSERT_EQ(rest->items.size(), 1u);
  EXPECT_EQ(rest->items[0].facts.keyframes, 13u);
  EXPECT_EQ(rest->items[0].facts.created, now_);
  EXPECT_EQ(rest->next_page_token, "");
}

TEST_F(StoredBackupsTest, AMissionThatSleepsIsReadForABackupOnlyWhereItHasChanged) {
  const auto needs = [this] {
    now_ += absl::Hours(1);
    const auto made = backups_->StoreIfChanged("m", absl::ZeroDuration());
    EXPECT_TRUE(made.ok()) << made.status();
    return made.ok() && *made;
  };
  Stream("m", 3);
  EXPECT_TRUE(needs());
  ASSERT_TRUE(store_->SleepMission("m").ok());
  EXPECT_FALSE(needs());
  EXPECT_TRUE(store_->GetMission("m")->asleep) << "it was not read for nothing";
  // Its last use is before the backup by these clocks, as where fusion goes on alone.
  Stream("m", 1);
  ASSERT_TRUE(store_->SleepMission("m").ok());
  EXPECT_TRUE(needs());
  EXPECT_EQ(Numbers("m").size(), 2u);
}

TEST_F(StoredBackupsTest, AMissionThatHasNotChangedNeedsNoneButAnotherOfItsNameDoes) {
  const auto needs = [this](absl::Duration least_age) {
    const auto made = backups_->StoreIfChanged("m", least_age);
    EXPECT_TRUE(made.ok()) << made.status();
    return made.ok() && *made;
  };
  Stream("m", 3);
  EXPECT_TRUE(needs(absl::Hours(1)));
  EXPECT_FALSE(needs(absl::ZeroDuration()));
  OpenBoth();
  EXPECT_FALSE(needs(absl::ZeroDuration())) << "nor after a restart";
  Stream("m", 1);
  now_ += absl::Minutes(30);
  EXPECT_FALSE(needs(absl::Hours(1))) << "the last one is young";
  now_ += absl::Minutes(31);
  EXPECT_TRUE(needs(absl::Hours(1)));
  // Another mission of the same name and length.
  ASSERT_TRUE(store_->DeleteMission("m").ok());
  Stream("m", 3);
  Stream("m", 1);
  EXPECT_TRUE(needs(absl::ZeroDuration()));
  EXPECT_TRUE(absl::IsNotFound(backups_->Store("nobody").status()));
  EXPECT_FALSE(fs::exists(fs::path(Shelf()) / "nobody"));
}

TEST_F(StoredBackupsTest, OldOnesGoWithTheirFilesAndTheLastGoodOneStays) {
  OpenBoth(/*keep=*/2);
  for (int i = 0; i < 4; ++i) {
    Stream("m", 2);
    Store("m");
  }
  EXPECT_EQ(Numbers("m"), (std::vector<uint32_t>{3, 4}));
  fs::remove_all(fs::path(Shelf()) / "m" / "meta" / "4");
  Stream("m", 1);
  Store("m");
  const std::vector<uint32_t> numbers = Numbers("m");
  EXPECT_EQ(numbers.front(), 3u) << "two are left that are whole";
  EXPECT_EQ(numbers.size(), 2u);
}

TEST_F(StoredBackupsTest, OneThatIsDeletedGoesWithItsFilesAndTheOthersStaySound) {
  Stream("m", 6);
  ASSERT_EQ(Store("m"), 1u);
  const std::string first = DumpLocal("m", *store_);
  const uint64_t one = BytesIn(Shelf());
  Stream("m", 6);
  ASSERT_EQ(Store("m"), 2u);
  ASSERT_EQ(Store("m"), 3u);
  EXPECT_TRUE(absl::IsFailedPrecondition(backups_->Remove("m", 2, now_).status()))
      << "the third was made then";
  const auto gone = backups_->Remove("m", 2, now_ - absl::Minutes(10));
  ASSERT_TRUE(gone.ok()) << gone.status();
  EXPECT_EQ(gone->facts.keyframes, 12u);
  EXPECT_THAT(Numbers("m"), ::testing::ElementsAre(1u, 3u));
  EXPECT_TRUE(backups_->Verify("m", 3).ok());
  ASSERT_TRUE(backups_->Remove("m", 3, {}).ok());
  EXPECT_LT(BytesIn(Shelf()), one + one / 2) << "what the second and third shared is gone";
  ASSERT_TRUE(backups_->Restore("m", 1, "then").ok());
  EXPECT_EQ(DumpLocal("then", *store_), first);
  EXPECT_TRUE(absl::IsNotFound(backups_->Remove("m", 3, {}).status()));
  EXPECT_TRUE(absl::IsNotFound(backups_->Remove("nobody", 1, {}).status()));
  EXPECT_FALSE(fs::exists(fs::path(Shelf()) / "nobody"));
  EXPECT_TRUE(backups_->Remove("m", 1, {}).ok()) << "the last good one, too";
  EXPECT_TRUE(Numbers("m").empty());
}

TEST_F(StoredBackupsTest, OneThatIsDamagedCanBeDeletedAndOneThatIsReadCannot) {
  Stream("m", 6);
  ASSERT_EQ(Store("m"), 1u);
  std::ofstream(fs::path(Shelf()) / "m" / "meta" / "1") << "rubbish";
  const auto gone = backups_->Remove("m", 1, {});
  ASSERT_TRUE(gone.ok()) << gone.status();
  EXPECT_NE(gone->damage, "");
  EXPECT_FALSE(fs::exists(fs::path(Shelf()) / "m" / "meta" / "1"));
  ASSERT_EQ(Store("m"), 1u) << "the number is given again";
  BackupOptions options;
  options.directory = Shelf();
  auto folder = BackupFolder::Open(journal_, options);
  ASSERT_TRUE(folder.ok()) << folder.status();
  auto reading = (*folder)->Open("m", 1);
  ASSERT_TRUE(reading.ok()) << reading.status();
  EXPECT_TRUE(absl::IsFailedPrecondition((*folder)->Remove("m", 1)));
  reading->reset();
  EXPECT_TRUE((*folder)->Remove("m", 1).ok());
}

TEST_F(StoredBackupsTest, WithoutRoomItIsRefusedWithTheNumbersAndLeavesNothing) {
  Stream("m", 4);
  free_bytes_ = 1000;
  const absl::Status refused = backups_->Store("m").status();
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("has 1000 free"));
  EXPECT_TRUE(Numbers("m").empty());
  EXPECT_LT(BytesIn(Shelf()), 1000u);
  free_bytes_ = uint64_t{1} << 40;
  EXPECT_EQ(Store("m"), 1u);
}

TEST_F(StoredBackupsTest, DamageIsFoundByItsFileAndIsThatBackupsAlone) {
  Stream("m", 8);
  ASSERT_EQ(Store("m"), 1u);
  Stream("other", 3);
  ASSERT_EQ(Store("other"), 1u);
  const auto whole = backups_->Verify("m", 1);
  ASSERT_TRUE(whole.ok()) << whole.status();
  const fs::path file = LargestShared("m");
  Spoil(file);
  const absl::Status damaged = backups_->Verify("m", 1).status();
  EXPECT_TRUE(absl::IsDataLoss(damaged)) << damaged;
  EXPECT_THAT(std::string(damaged.message()), HasSubstr(file.filename().string()));
  EXPECT_TRUE(absl::IsDataLoss(backups_->Restore("m", 1, "x")));
  EXPECT_TRUE(absl::IsNotFound(store_->GetMission("x").status()));
  EXPECT_TRUE(backups_->Verify("other", 1).ok());
  fs::remove(file);
  const absl::Status lost = backups_->Verify("m", 1).status();
  EXPECT_TRUE(absl::IsDataLoss(lost)) << lost;
}

// Turns a bit in the middle of the file.
void TurnABit(const fs::path& file) {
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  const auto place = static_cast<std::streamoff>(fs::file_size(file) / 2);
  stream.seekg(place);
  const char byte = static_cast<char>(stream.get() ^ 1);
  stream.seekp(place);
  stream.put(byte);
}

TEST_F(StoredBackupsTest, ANewBackupNeverRestsOnADamagedFileAndMendsThoseThatDo) {
  Stream("m", 12);
  ASSERT_EQ(Store("m"), 1u);
  TurnABit(LargestShared("m"));
  EXPECT_TRUE(absl::IsDataLoss(backups_->Verify("m", 1).status()));
  EXPECT_EQ(backups_->health().damaged, 1u);
  Stream("m", 1);
  ASSERT_EQ(Store("m"), 2u);
  EXPECT_TRUE(backups_->Verify("m", 2).ok());
  EXPECT_TRUE(backups_->Verify("m", 1).ok()) << "they share the file";
  EXPECT_EQ(backups_->health().damaged, 0u);
}

TEST_F(StoredBackupsTest, StoredBackupsAreComparedAndWhatIsDamagedIsSaid) {
  Stream("m", 12);
  ASSERT_EQ(Store("m"), 1u);
  Stream("n", 3);
  ASSERT_EQ(Store("n"), 1u);
  EXPECT_EQ(backups_->health().unverified, 0u) << "a new one is compared as it is made";
  const auto any = [](uint64_t) { return true; };
  ASSERT_TRUE(backups_->CompareAll(any).ok());
  TurnABit(LargestShared("m"));
  EXPECT_TRUE(absl::IsCancelled(backups_->CompareAll([](uint64_t) { return false; })));
  ASSERT_TRUE(backups_->CompareAll(any).ok());
  EXPECT_EQ(backups_->health().damaged, 1u);
  const auto list = backups_->List("", {.page_size = 9, .page_token = ""});
  ASSERT_EQ(list->items.size(), 2u);
  EXPECT_THAT(list->items[0].damage, HasSubstr(LargestShared("m").filename().string()));
  EXPECT_EQ(list->items[1].damage, "");
  EXPECT_GT(list->items[1].verified, absl::UnixEpoch());
  // It is known after a restart, too, and the next round makes another one.
  OpenBoth();
  EXPECT_EQ(backups_->health().damaged, 1u);
  const auto made = backups_->StoreIfChanged("m", absl::Hours(9));
  ASSERT_TRUE(made.ok()) << made.status();
  EXPECT_TRUE(*made);
  ASSERT_TRUE(backups_->CompareAll(any).ok());
  EXPECT_EQ(backups_->health().damaged, 0u);
}

TEST_F(StoredBackupsTest, BackupsAreCountedByMissionAndNotByName) {
  OpenBoth(/*keep=*/2);
  Stream("m", 3);
  const std::string first = store_->GetMission("m")->uid;
  ASSERT_EQ(Store("m"), 1u);
  ASSERT_TRUE(store_->DeleteMission("m").ok());
  for (int i = 0; i < 3; ++i) {
    Stream("m", 2);
    Store("m");
  }
  EXPECT_EQ(Numbers("m"), (std::vector<uint32_t>{1, 3, 4})) << "the deleted one's last one stays";
  const auto list = backups_->List("m", {.page_size = 9, .page_token = ""});
  EXPECT_EQ(list->items[0].facts.mission_uid, first);
  EXPECT_EQ(list->items[1].facts.mission_uid, store_->GetMission("m")->uid);
}

TEST_F(StoredBackupsTest, AFolderOfAnotherStoreIsRefusedAndCanBeTakenOver) {
  Stream("m", 3);
  ASSERT_EQ(Store("m"), 1u);
  RocksJournalOptions other_options;
  other_options.directory = Folder("other");
  const auto other = RocksJournal::Open(other_options);
  ASSERT_TRUE(other.ok()) << other.status();
  BackupOptions options;
  options.directory = Shelf();
  const absl::Status refused = BackupFolder::Open(other->get(), options).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  const std::string message(refused.message());
  EXPECT_THAT(message, HasSubstr("--backup-take-over "));
  options.take_over_from = "somebody";
  EXPECT_FALSE(BackupFolder::Open(other->get(), options).ok());
  options.take_over_from = message.substr(message.rfind(' ') + 1);
  const auto taken = BackupFolder::Open(other->get(), options);
  ASSERT_TRUE(taken.ok()) << taken.status();
  EXPECT_EQ((*taken)->List("m")->size(), 1u);
  // Who had it before writes no more.
  now_ += absl::Hours(1);
  EXPECT_TRUE(absl::IsFailedPrecondition(backups_->Store("m").status()));
}

TEST_F(StoredBackupsTest, AnArchiveTakesAMissionAwayAndBringsItBack) {
  Stream("m", 5);
  const std::string local = DumpLocal("m", *store_);
  SessionRequest request;
  request.mission = "m";
  request.agent = "late";
  const auto session = store_->OpenSession(request);
  ASSERT_TRUE(session.ok());
  const absl::Status refused = backups_->Archive("m").status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("late"));
  EXPECT_TRUE(Numbers("m").empty());
  store_->CloseSession(session->session_id);
  const auto archived = backups_->Archive("m");
  ASSERT_TRUE(archived.ok()) << archived.status();
  EXPECT_TRUE(archived->facts.archived);
  EXPECT_TRUE(absl::IsNotFound(store_->GetMission("m").status()));
  EXPECT_FALSE(fs::exists(MissionFolder("m")));
  EXPECT_TRUE(absl::IsNotFound(backups_->Archive("m").status()));
  // Backups of a mission that has the name now don't drive the archive out.
  OpenBoth(/*keep=*/1);
  for (int i = 0; i < 3; ++i) {
    Stream("m", 1);
    Store("m");
  }
  EXPECT_EQ(Numbers("m"), (std::vector<uint32_t>{1, 4}));
  ASSERT_TRUE(backups_->Restore("m", 1, "back").ok());
  EXPECT_EQ(DumpLocal("back", *store_), local);
}

TEST_F(StoredBackupsTest, WhatWasWrittenMeanwhileIsNeverArchivedAway) {
  Stream("m", 3);
  const absl::Status kept = store_->DeleteUnusedMission(
      "m", [] { return absl::FailedPreconditionError("it has changed"); });
  EXPECT_TRUE(absl::IsFailedPrecondition(kept)) << kept;
  Stream("m", 1);
  EXPECT_EQ(store_->GetMission("m")->keyframes, 4u);
}

// A robot that connects while the mission goes into the archive is told to come again, and neither
// gets a session in what is deleted nor keeps it from being archived.
TEST_F(StoredBackupsTest, NobodyEntersAMissionThatIsBeingArchived) {
  Stream("m", 3);
  SessionRequest request;
  request.mission = "m";
  request.agent = "late";
  absl::Status refused;
  ASSERT_TRUE(store_
                  ->DeleteUnusedMission("m",
                                        [&] {
                                          refused = store_->OpenSession(request).status();
                                          return absl::OkStatus();
                                        })
                  .ok());
  EXPECT_TRUE(absl::IsUnavailable(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr("archived"));
  EXPECT_TRUE(absl::IsNotFound(store_->GetMission("m").status()));
  EXPECT_TRUE(store_->OpenSession(request).ok()) << "it begins another one";
}

// Robots come and go while it is tried: each that gets a session has a mission that stays.
TEST_F(StoredBackupsTest, WhoGotASessionHasItsMission) {
  std::atomic<bool> ends = false;
  std::atomic<int> entered = 0;
  std::thread robot([&] {
    SessionRequest request;
    request.mission = "m";
    request.agent = "guest";
    while (!ends) {
      const auto session = store_->OpenSession(request);
      if (!session.ok()) {
        EXPECT_TRUE(absl::IsUnavailable(session.status())) << session.status();
        continue;
      }
      ++entered;
      EXPECT_TRUE(store_->GetMission("m").ok());
      store_->CloseSession(session->session_id);
    }
  });
  for (int i = 0; i < 200 || entered < 20; ++i) {
    const absl::Status deleted = store_->DeleteUnusedMission("m", [] { return absl::OkStatus(); });
    EXPECT_TRUE(deleted.ok() || absl::IsFailedPrecondition(deleted) || absl::IsNotFound(deleted))
        << deleted;
  }
  ends = true;
  robot.join();
}

TEST_F(StoredBackupsTest, ADamagedMissionIsRestoredAndHasNoNewBackups) {
  Stream("m", 6);
  const std::string local = DumpLocal("m", *store_);
  ASSERT_EQ(Store("m"), 1u);
  backups_.reset();
  Close();
  for (const fs::path& log : Files("m", ".log")) fs::remove(log);
  OpenBoth();
  ASSERT_FALSE(store_->GetMission("m")->damage.empty());
  const absl::Status refused = backups_->Store("m").status();
  EXPECT_TRUE(absl::IsDataLoss(refused)) << refused;
  EXPECT_TRUE(absl::IsDataLoss(backups_->Archive("m").status()));
  EXPECT_TRUE(absl::IsDataLoss(backups_->Restore("m", 1, "m"))) << "its name is not free";
  ASSERT_TRUE(backups_->Restore("m", 1, "m2").ok());
  EXPECT_EQ(DumpLocal("m2", *store_), local);
}

TEST_F(StoredBackupsTest, TheFolderIsApartFromTheData) {
  BackupOptions options;
  for (const std::string& directory :
       {Data() + "/backups", Data(), Data() + "/../data/x", Folder("")}) {
    options.directory = directory;
    EXPECT_TRUE(absl::IsInvalidArgument(BackupFolder::Open(journal_, options).status()))
        << directory;
  }
  options.directory = Data() + "2";
  EXPECT_TRUE(BackupFolder::Open(journal_, options).ok());
}

}  // namespace
}  // namespace corbslam::map_store
