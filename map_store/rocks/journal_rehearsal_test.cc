// Tests upgrades of folders of older formats: rehearsed, cut short, and done.
#include "map_store/rocks/journal_rehearsal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rocksdb/db.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/testing/journal_room.h"
#include "map_store/testing/store_dump.h"
#include "slam/util/program_version.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DumpLocal;
using ::testing::HasSubstr;

class JournalRehearsalTest : public testing::JournalRoom {
 protected:
  JournalRehearsalTest() {
    Open();
    for (const char* name : {"a", "b"}) {
      Stream(name, 5);
      dumps_[name] = DumpLocal(name, *store_);
    }
    Close();
  }

  // Makes the folder one of format 10: all missions in the guard's database.
  void MakeOld(const std::string& format = std::string("\x0a\0\0\0", 4)) {
    const std::unique_ptr<rocksdb::DB> shared = OpenAt(Data(), false);
    for (const char* name : {"a", "b"}) {
      const std::unique_ptr<rocksdb::DB> own = OpenAt(MissionFolder(name).string(), true);
      const std::unique_ptr<rocksdb::Iterator> it(own->NewIterator({}));
      for (it->SeekToFirst(); it->Valid(); it->Next()) {
        ASSERT_TRUE(shared->Put({}, it->key(), it->value()).ok());
      }
    }
    ASSERT_TRUE(shared->Put({}, map_store::FormatKey(), format).ok());
    ASSERT_TRUE(shared->Flush({}).ok());
    ASSERT_TRUE(shared->Close().ok());
    fs::remove_all(fs::path(Data()) / "missions");
  }
  static std::unique_ptr<rocksdb::DB> OpenAt(const std::string& path, bool only_read) {
    rocksdb::DB* raw = nullptr;
    const rocksdb::Status opened = only_read ? rocksdb::DB::OpenForReadOnly({}, path, &raw)
                                             : rocksdb::DB::Open({}, path, &raw);
    EXPECT_TRUE(opened.ok()) << opened.ToString();
    return std::unique_ptr<rocksdb::DB>(raw);
  }
  void ExpectUpgraded() {
    Open();
    for (const auto& [name, dump] : dumps_) EXPECT_EQ(DumpLocal(name, *store_), dump);
    Close();
  }
  fs::path Upgrading(const std::string& name) const {
    return fs::path(Data()) / "missions.upgrading" / (name + ".mission");
  }

  std::map<std::string, std::string> dumps_;
};

TEST_F(JournalRehearsalTest, SaysWhatWouldHappenAndChangesNothing) {
  MakeOld();
  const auto plan = map_store::PlanUpgrade(Data());
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_TRUE(plan->needed());
  EXPECT_EQ(plan->from, 10u);
  EXPECT_EQ(plan->to, kJournalFormat);
  ASSERT_EQ(plan->missions.size(), 2u);
  EXPECT_EQ(plan->missions[0].name, "a");
  EXPECT_EQ(plan->missions[0].keyframes, 5u);
  EXPECT_GT(plan->missions[0].records, 4u);
  EXPECT_GT(plan->bytes_needed, 10000u);
  EXPECT_GT(plan->bytes_free, 0u);
  EXPECT_FALSE(fs::exists(fs::path(Data()) / "missions"));
  EXPECT_FALSE(fs::exists(fs::path(Data()) / "missions.upgrading"));
  ASSERT_TRUE(map_store::UpgradeFolder(Data()).ok());
  EXPECT_FALSE(map_store::PlanUpgrade(Data())->needed());
  ExpectUpgraded();
}

// What a kill between two missions leaves: the first is copied, the second half.
TEST_F(JournalRehearsalTest, AnUpgradeThatWasCutShortGoesOn) {
  fs::copy(MissionFolder("a"), Folder("a_copied"), fs::copy_options::recursive);
  MakeOld();
  std::string identity;
  uint64_t sequence = 0;
  {
    const auto shared = OpenAt(Data(), true);
    ASSERT_TRUE(shared->GetDbIdentity(identity).ok());
    sequence = shared->GetLatestSequenceNumber();
  }
  fs::create_directories(Upgrading("b"));
  std::ofstream(Upgrading("b") / "CURRENT") << "half";
  fs::copy(Folder("a_copied"), Upgrading("a"), fs::copy_options::recursive);
  std::ofstream(Upgrading("a") / "was_there_before") << "yes";
  std::ofstream(fs::path(Data()) / "missions.upgrading" / "SOURCE")
      << identity << " " << sequence << "\n";
  ASSERT_TRUE(map_store::UpgradeFolder(Data()).ok());
  EXPECT_TRUE(fs::exists(MissionFolder("a") / "was_there_before")) << "it was not copied again";
  ExpectUpgraded();
}

// An older program may have written since.
TEST_F(JournalRehearsalTest, CopiesOfAnotherStateAreMadeAnew) {
  fs::copy(MissionFolder("a"), Folder("a_copied"), fs::copy_options::recursive);
  MakeOld();
  fs::create_directories(Upgrading("a").parent_path());
  fs::copy(Folder("a_copied"), Upgrading("a"), fs::copy_options::recursive);
  std::ofstream(Upgrading("a") / "was_there_before") << "yes";
  std::ofstream(fs::path(Data()) / "missions.upgrading" / "SOURCE") << "another 1\n";
  ASSERT_TRUE(map_store::UpgradeFolder(Data()).ok());
  EXPECT_FALSE(fs::exists(MissionFolder("a") / "was_there_before"));
  ExpectUpgraded();
}

TEST_F(JournalRehearsalTest, MissionsWithFoldersOfTheirOwnChangeWhereTheyAre) {
  {
    const auto guard = OpenAt(Data(), false);
    ASSERT_TRUE(guard->Put({}, map_store::FormatKey(), std::string("\x0b\0\0\0", 4)).ok());
  }
  const auto plan = map_store::PlanUpgrade(Data());
  ASSERT_TRUE(plan.ok()) << plan.status();
  EXPECT_EQ(plan->from, 11u);
  EXPECT_TRUE(plan->needed());
  EXPECT_EQ(plan->bytes_needed, 0u);
  ASSERT_EQ(plan->missions.size(), 2u);
  EXPECT_EQ(plan->missions[1].keyframes, 5u);
  ASSERT_TRUE(map_store::UpgradeFolder(Data()).ok());
  EXPECT_FALSE(map_store::PlanUpgrade(Data())->needed());
  ExpectUpgraded();
}

TEST_F(JournalRehearsalTest, ANewerFormatIsRefusedWithBothNumbersAndItsProgram) {
  {
    const auto guard = OpenAt(Data(), false);
    std::string program;
    ASSERT_TRUE(guard->Get({}, map_store::ProgramKey(), &program).ok());
    EXPECT_EQ(program, CorbslamVersion());
    ASSERT_TRUE(guard->Put({}, map_store::FormatKey(), std::string("\x63\0\0\0", 4)).ok());
    ASSERT_TRUE(guard->Put({}, map_store::ProgramKey(), "9.8.7").ok());
  }
  const absl::Status refused = map_store::PlanUpgrade(Data()).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  for (const std::string& part : {std::string("format 99"), absl::StrCat("5 to ", kJournalFormat),
                                  std::string("version 9.8.7")}) {
    EXPECT_THAT(std::string(refused.message()), HasSubstr(part));
  }
  EXPECT_THAT(std::string(RocksJournal::Open({.directory = Data()}).status().message()),
              HasSubstr("version 9.8.7"));
}

TEST_F(JournalRehearsalTest, AFolderThatIsInUseOrEmptyIsNotTouched) {
  EXPECT_FALSE(map_store::PlanUpgrade(Data())->needed());
  Open();
  EXPECT_TRUE(absl::IsFailedPrecondition(map_store::PlanUpgrade(Data()).status()));
  Close();
  EXPECT_TRUE(absl::IsFailedPrecondition(map_store::PlanUpgrade(Folder("nothing")).status()));
  fs::create_directories(Folder("empty"));
  EXPECT_EQ(map_store::PlanUpgrade(Folder("empty"))->from, 0u);
  EXPECT_TRUE(fs::is_empty(Folder("empty")));
}

}  // namespace
}  // namespace corbslam::map_store
