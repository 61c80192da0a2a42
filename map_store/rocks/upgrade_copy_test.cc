#include "map_store/rocks/upgrade_copy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rocksdb/db.h>

#include <filesystem>
#include <memory>
#include <string>

#include "map_store/archive/formats.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/testing/rocks_store.h"
#include "map_store/testing/store_dump.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DumpLocal;

constexpr uint32_t kOlder = kOldestJournalFormat;

// Makes of the journal, which nobody has open, one of that format; returns the format before.
std::string SetFormat(const std::string& folder, uint32_t format) {
  rocksdb::DB* raw = nullptr;
  EXPECT_TRUE(rocksdb::DB::Open({}, folder, &raw).ok());
  const std::unique_ptr<rocksdb::DB> guard(raw);
  std::string before;
  EXPECT_TRUE(guard->Get({}, FormatKey(), &before).ok());
  EXPECT_TRUE(guard->Put({}, FormatKey(), std::string{static_cast<char>(format), 0, 0, 0}).ok());
  return before;
}

class UpgradeCopyTest : public testing::RocksStoreTest {
 protected:
  // Leaves a journal of an older format; returns what its mission holds.
  std::string MakeOlder() {
    auto store = Open(options_);
    Send(MakeBatches(), 0, 6, store.get());
    const std::string local = DumpLocal(kMission, *store);
    store.reset();
    SetFormat(options_.directory, kOlder);
    return local;
  }

  const RocksJournalOptions options_{.directory = Folder("store")};
  const std::string copy_ = UpgradeCopyPath(options_.directory, kOlder);
};

TEST_F(UpgradeCopyTest, TheOlderProgramCanBeStartedOnWhatIsKept) {
  const std::string local = MakeOlder();
  auto store = Open(options_);
  ASSERT_TRUE(store->DeleteMission(kMission).ok());
  store.reset();
  // This program reads the older format, too, and stands for the older one.
  store = Open({.directory = copy_});
  EXPECT_EQ(DumpLocal(kMission, *store), local);
  store.reset();
  EXPECT_TRUE(fs::exists(UpgradeCopyPath(copy_, kOlder))) << "the copy had the older format";
}

TEST_F(UpgradeCopyTest, NothingIsKeptOfAJournalOfThisFormat) {
  auto store = Open(options_);
  Send(MakeBatches(), 0, 6, store.get());
  store.reset();
  store = Open(options_);
  store.reset();
  for (const auto& entry : fs::directory_iterator(options_.directory)) {
    EXPECT_FALSE(entry.path().filename().string().starts_with("before-")) << entry.path();
  }
}

TEST_F(UpgradeCopyTest, WhatWasCutShortIsMadeAnewAndWhatIsWholeStays) {
  const std::string local = MakeOlder();
  fs::create_directories(copy_ + ".making/missions");
  ASSERT_TRUE(KeepBeforeUpgrade(options_.directory, kOlder).ok());
  EXPECT_FALSE(fs::exists(copy_ + ".making"));
  const auto made = fs::last_write_time(copy_);
  ASSERT_TRUE(KeepBeforeUpgrade(options_.directory, kOlder).ok());
  EXPECT_EQ(fs::last_write_time(copy_), made);
  auto store = Open({.directory = copy_});
  EXPECT_EQ(DumpLocal(kMission, *store), local);
}

TEST_F(UpgradeCopyTest, AFolderThatCantBeWrittenToIsNamed) {
  const absl::Status kept = KeepBeforeUpgrade(Folder("nowhere"), kOlder);
  EXPECT_FALSE(kept.ok());
  EXPECT_THAT(kept.message(), ::testing::HasSubstr(Folder("nowhere")));
}

}  // namespace
}  // namespace corbslam::map_store
