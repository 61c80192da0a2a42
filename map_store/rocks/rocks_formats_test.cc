// Tests that the formats of releases are read or refused by name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rocksdb/db.h>

#include <filesystem>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/archive/archive.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/rocks/upgrade_copy.h"
#include "map_store/testing/rocks_store.h"
#include "map_store/testing/store_dump.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DumpLocal;
using ::testing::HasSubstr;

class RocksFormatsTest : public testing::RocksStoreTest {
 protected:
  // Makes of a journal what programs of older formats wrote: one database with all missions.
  static void MakeShared(const std::string& folder, const std::string& format) {
    rocksdb::DB* raw = nullptr;
    ASSERT_TRUE(rocksdb::DB::Open({}, folder, &raw).ok());
    const std::unique_ptr<rocksdb::DB> shared(raw);
    std::string before;
    ASSERT_TRUE(shared->Get({}, map_store::FormatKey(), &before).ok());
    EXPECT_EQ(before, map_store::EncodeFormat());
    ASSERT_TRUE(rocksdb::DB::OpenForReadOnly({}, MissionFolder(folder), &raw).ok());
    const std::unique_ptr<rocksdb::DB> own(raw);
    const std::unique_ptr<rocksdb::Iterator> it(own->NewIterator({}));
    for (it->SeekToFirst(); it->Valid(); it->Next()) {
      ASSERT_TRUE(shared->Put({}, it->key(), it->value()).ok());
    }
    ASSERT_TRUE(shared->Put({}, map_store::FormatKey(), format).ok());
    ASSERT_TRUE(shared->Close().ok());
    fs::remove_all(map_store::JournalFolder(folder).path());
  }
};

TEST_F(RocksFormatsTest, TheFormatBeforeBecomesThisOneSoThatOlderProgramsRefuseIt) {
  const RocksJournalOptions options{.directory = Folder("store")};
  auto store = Open(options);
  Send(MakeBatches(), 0, 6, store.get());
  const size_t keyframes = store->GetMission(kMission)->keyframes;
  store.reset();
  rocksdb::DB* raw = nullptr;
  ASSERT_TRUE(rocksdb::DB::Open({}, options.directory, &raw).ok());
  std::unique_ptr<rocksdb::DB> guard(raw);
  ASSERT_TRUE(guard->Put({}, map_store::FormatKey(), std::string("\x0b\0\0\0", 4)).ok());
  guard.reset();
  store = Open(options);
  EXPECT_EQ(store->GetMission(kMission)->keyframes, keyframes);
  store.reset();
  ASSERT_TRUE(rocksdb::DB::OpenForReadOnly({}, options.directory, &raw).ok());
  guard.reset(raw);
  std::string format;
  ASSERT_TRUE(guard->Get({}, map_store::FormatKey(), &format).ok());
  EXPECT_EQ(format, map_store::EncodeFormat());
}

// A program before recorded cameras left format 5.
TEST_F(RocksFormatsTest, AnOlderFormatIsReadAndBecomesTheNewOne) {
  const RocksJournalOptions options{.directory = Folder("store")};
  auto store = Open(options);
  Send(MakeBatches(), 0, 6, store.get());
  const std::string local = DumpLocal(kMission, *store);
  store.reset();
  MakeShared(options.directory, std::string("\x05\0\0\0", 4));
  store = Open(options);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(store->GetMission(kMission)->keyframes, 6u);
  EXPECT_EQ(DumpLocal(kMission, *store), local);
  // The missions have left the old database.
  const std::string kept = map_store::UpgradeCopyPath(options.directory, 5);
  EXPECT_LT(map_store::BytesIn(options.directory) - map_store::BytesIn(kept),
            map_store::BytesIn(MissionFolder(options.directory)) + (64 << 10));
  store.reset();
  MakeShared(options.directory, std::string("\x04\0\0\0", 4));
  EXPECT_EQ(TryOpen(options).status().code(), absl::StatusCode::kFailedPrecondition);
}

// Puts another format's number into a database, and returns the one that was there.
std::string SwapFormat(const std::string& folder, const std::string& format) {
  rocksdb::DB* raw = nullptr;
  EXPECT_TRUE(rocksdb::DB::Open({}, folder, &raw).ok());
  const std::unique_ptr<rocksdb::DB> database(raw);
  std::string before;
  EXPECT_TRUE(database->Get({}, map_store::FormatKey(), &before).ok());
  EXPECT_TRUE(database->Put({}, map_store::FormatKey(), format).ok());
  EXPECT_TRUE(database->Close().ok());
  return before;
}

// A program before profiles left format 11, in the guard and in each mission.
TEST_F(RocksFormatsTest, AJournalWithoutProfilesBecomesOneThatOlderProgramsRefuse) {
  const RocksJournalOptions options{.directory = Folder("store")};
  auto store = Open(options);
  Send(MakeBatches(), 0, 6, store.get());
  const std::string local = DumpLocal(kMission, *store);
  store.reset();
  const std::string eleven("\x0b\0\0\0", 4);
  const std::string now = map_store::EncodeFormat();
  EXPECT_EQ(SwapFormat(options.directory, eleven), now);
  EXPECT_EQ(SwapFormat(MissionFolder(options.directory), eleven), now);
  store = Open(options);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(DumpLocal(kMission, *store), local);
  MissionProfile values;
  values.description = "set";
  ASSERT_TRUE(store->UpdateMission(kMission, values, {ProfileField::kDescription}).ok());
  store.reset();
  EXPECT_EQ(SwapFormat(options.directory, now), now);
  EXPECT_EQ(SwapFormat(MissionFolder(options.directory), now), now);
  store = Open(options);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(store->GetMission(kMission)->profile.description, "set");
  EXPECT_EQ(DumpLocal(kMission, *store), local);
}

TEST_F(RocksFormatsTest, ANewerFormatAndASecondProcessAreRefusedByName) {
  const RocksJournalOptions options{.directory = Folder("store")};
  auto first = RocksJournal::Open(options);
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = RocksJournal::Open(options);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(second.status().message()), HasSubstr(options.directory));
  EXPECT_THAT(std::string(second.status().message()), HasSubstr("this process itself has it"));

  first->reset();
  rocksdb::DB* raw = nullptr;
  ASSERT_TRUE(rocksdb::DB::Open({}, options.directory, &raw).ok());
  const std::unique_ptr<rocksdb::DB> closing(raw);
  map_store::ArchiveWriter next;
  next(map_store::kJournalFormat + 1);
  ASSERT_TRUE(raw->Put({}, map_store::FormatKey(), next.Take()).ok());
  ASSERT_TRUE(raw->Close().ok());
  const auto newer = RocksJournal::Open(options);
  EXPECT_EQ(newer.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(newer.status().message()),
              HasSubstr(absl::StrCat("has format ", map_store::kJournalFormat + 1)));

  const auto nowhere = RocksJournal::Open({.directory = "/proc/version/journal"});
  EXPECT_EQ(nowhere.status().code(), absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace corbslam::map_store
