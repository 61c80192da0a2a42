// Tests the alerts' advice for a full disk: delete missions, and the store goes on.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/testing/feature_mission.h"
#include "tests/fault/disk/small_disk.h"

namespace corbslam::tests {
namespace {

namespace fs = std::filesystem;
using map_store::MissionState;
using map_store::RocksJournal;
using map_store::RocksJournalOptions;
using testing::MakeFeatureMission;

constexpr uint64_t kMiB = 1 << 20;

class FullOfMissionsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_);
    auto disk = SmallDisk::Mount(folder_, 128 * kMiB);
    if (!disk.ok()) {
      ASSERT_EQ(std::getenv("CI"), nullptr) << disk.status();
      GTEST_SKIP() << "needs to be root on Linux: " << disk.status();
    }
    disk_ = *std::move(disk);
    Open();
  }
  void Open() {
    journal_.reset();
    auto journal = RocksJournal::Open(options_);
    ASSERT_TRUE(journal.ok()) << journal.status();
    journal_ = *std::move(journal);
  }
  // Creates missions until there is no room, and returns how many.
  int Fill() {
    for (int made = 0; made < 100; ++made) {
      const absl::Status status = journal_->CreateMission(absl::StrCat("m", made), state_);
      if (status.ok()) continue;
      EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
      return made;
    }
    return 100;
  }
  uint64_t Used() const {
    const fs::space_info space = fs::space(folder_);
    return space.capacity - space.free;
  }

  const std::string folder_ = ::testing::TempDir() + "/full_of_missions";
  const RocksJournalOptions options_{.directory = folder_ + "/data", .min_free_bytes = 16 * kMiB};
  const MissionState state_ = MakeFeatureMission("m", 200, 1500);
  std::unique_ptr<SmallDisk> disk_;
  std::unique_ptr<RocksJournal> journal_;
};

TEST_F(FullOfMissionsTest, DeletingOneMakesRoomForTheNext) {
  const int made = Fill();
  ASSERT_GT(made, 3);
  for (int i = 0; i < made - 1; ++i) {
    ASSERT_TRUE(journal_->DeleteMission(absl::StrCat("m", i)).ok());
    const absl::Status again = journal_->CreateMission(absl::StrCat("again", i), state_);
    EXPECT_TRUE(again.ok()) << i << ": " << again;
  }
  EXPECT_TRUE(journal_->CheckWritable().ok());
}

// Not even the reserve is left: somebody else's files have taken it.
TEST_F(FullOfMissionsTest, MissionsCanBeDeletedOnADiskWithoutAByteLeft) {
  const int made = Fill();
  ASSERT_TRUE(disk_->Fill(0).ok());
  EXPECT_TRUE(absl::IsResourceExhausted(journal_->CheckWritable()));
  const uint64_t before = Used();
  for (int i = 0; i < made - 1; ++i) {
    const absl::Status deleted = journal_->DeleteMission(absl::StrCat("m", i));
    ASSERT_TRUE(deleted.ok()) << deleted;
  }
  EXPECT_LT(Used() + 10 * kMiB * static_cast<uint64_t>(made - 1), before);
  EXPECT_TRUE(journal_->CheckWritable().ok()) << journal_->CheckWritable();
  EXPECT_TRUE(journal_->CreateMission("next", state_).ok());
  // And a store that starts on such a disk has the rest.
  Open();
  EXPECT_EQ(journal_->ListMissions()->size(), 2u);
}

}  // namespace
}  // namespace corbslam::tests
