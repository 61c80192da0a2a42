// Tests that the formats of releases are read or refused by name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rocksdb/db.h>

#include <filesystem>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/archive/archive.h"
#include "map_store/archive/formats.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/journal_check.h"
#include "map_store/testing/rocks_store.h"
#include "map_store/testing/store_dump.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using testing::DumpLocal;
using ::testing::HasSubstr;

std::string Bytes(uint32_t format) {
  ArchiveWriter writer;
  writer(format);
  return writer.Take();
}

// Puts a value into a database that nobody has open, and returns the one that was there.
std::string Swap(const std::string& folder, const std::string& key, const std::string& value) {
  rocksdb::DB* raw = nullptr;
  EXPECT_TRUE(rocksdb::DB::Open({}, folder, &raw).ok());
  const std::unique_ptr<rocksdb::DB> database(raw);
  std::string before;
  EXPECT_TRUE(database->Get({}, key, &before).ok());
  EXPECT_TRUE(database->Put({}, key, value).ok());
  EXPECT_TRUE(database->Close().ok());
  return before;
}

class RocksFormatsTest : public testing::RocksStoreTest {
 protected:
  // Leaves a journal whose guard and whose mission say that they are of that format; returns what
  // the mission holds.
  std::string MakeJournal(uint32_t format) {
    auto store = Open(options_);
    Send(MakeBatches(), 0, 6, store.get());
    const std::string local = DumpLocal(kMission, *store);
    store.reset();
    SetFormat(format);
    return local;
  }
  void SetFormat(uint32_t format) {
    Swap(options_.directory, FormatKey(), Bytes(format));
    Swap(MissionFolder(options_.directory), FormatKey(), Bytes(format));
  }
  // Expects that a start and a check refuse the folder with such a message, and change no format.
  template <typename Matcher>
  void ExpectRefused(uint32_t format, const Matcher& message) {
    const absl::Status started = TryOpen(options_).status();
    const absl::Status checked = CheckJournal(options_.directory, [](const CheckedMission&) {});
    for (const absl::Status& refused : {started, checked}) {
      EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
      EXPECT_THAT(std::string(refused.message()), message);
      EXPECT_THAT(std::string(refused.message()), HasSubstr(options_.directory));
    }
    EXPECT_EQ(Swap(options_.directory, FormatKey(), Bytes(format)), Bytes(format));
  }

  const RocksJournalOptions options_{.directory = Folder("store")};
};

TEST_F(RocksFormatsTest, TheFormatBeforeBecomesThisOneSoThatOlderProgramsRefuseIt) {
  const std::string local = MakeJournal(kJournalFormat - 1);
  auto store = Open(options_);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(DumpLocal(kMission, *store), local);
  store.reset();
  const std::string now = EncodeFormat();
  EXPECT_EQ(Swap(options_.directory, FormatKey(), now), now);
  EXPECT_EQ(Swap(MissionFolder(options_.directory), FormatKey(), now), now);
}

TEST_F(RocksFormatsTest, AnOlderFormatIsRefusedWithWhatReadsIt) {
  const std::string local = MakeJournal(kOldestJournalFormat - 1);
  Swap(options_.directory, ProgramKey(), "0.0.9");
  ExpectRefused(
      kOldestJournalFormat - 1,
      AllOf(HasSubstr("has format 14, written by version 0.0.9"), HasSubstr("reads 15 to 16"),
            HasSubstr("map_store of commit f5f37d9e"), HasSubstr("docs/upgrade.md")));
  SetFormat(kJournalFormat);
  EXPECT_EQ(DumpLocal(kMission, *Open(options_)), local) << "nothing was changed";
}

// Up to format 10 all missions were in one database, which is the guard's.
TEST_F(RocksFormatsTest, AFolderWithoutFoldersOfMissionsIsRefusedByItsFormat) {
  MakeJournal(10);
  fs::remove_all(JournalFolder(options_.directory).path());
  ExpectRefused(10, AllOf(HasSubstr("has format 10"), HasSubstr("map_store of commit f5f37d9e")));
  EXPECT_FALSE(JournalFolder(options_.directory).exists());
}

// A mission that was asleep while others became of a newer format.
TEST_F(RocksFormatsTest, AMissionOfAnOlderFormatIsRefusedByItsFolder) {
  MakeJournal(kJournalFormat);
  Swap(MissionFolder(options_.directory), FormatKey(), Bytes(kOldestJournalFormat - 1));
  const absl::Status refused = TryOpen(options_).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), AllOf(HasSubstr(MissionFolder(options_.directory)),
                                                    HasSubstr("map_store of commit")));
}

TEST_F(RocksFormatsTest, ANewerFormatIsRefusedWithBothNumbersAndItsProgram) {
  MakeJournal(kJournalFormat + 1);
  Swap(options_.directory, ProgramKey(), "9.8.7");
  ExpectRefused(kJournalFormat + 1,
                AllOf(HasSubstr(absl::StrCat("has format ", kJournalFormat + 1)),
                      HasSubstr("version 9.8.7"), HasSubstr("start the newer program")));
}

TEST_F(RocksFormatsTest, ASecondProcessIsRefusedByName) {
  auto first = RocksJournal::Open(options_);
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = RocksJournal::Open(options_);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(second.status().message()),
              AllOf(HasSubstr(options_.directory), HasSubstr("this process itself has it")));
  const auto nowhere = RocksJournal::Open({.directory = "/proc/version/journal"});
  EXPECT_EQ(nowhere.status().code(), absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace corbslam::map_store
