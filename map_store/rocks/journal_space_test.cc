// Tests that a journal gives back to the disk what it needs no more.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "map_store/archive/state_archive.h"
#include "map_store/records/mission_contents.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/testing/feature_mission.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::MakeFeatureMission;

constexpr uint64_t kMiB = 1 << 20;
constexpr uint32_t kKeyframes = 300;
constexpr size_t kFeatures = 1500;

class JournalSpaceTest : public ::testing::Test {
 protected:
  JournalSpaceTest() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    Open();
  }
  ~JournalSpaceTest() override {
    journal_.reset();
    fs::remove_all(folder_);
  }

  void Open() {
    journal_.reset();
    auto opened = RocksJournal::Open({.directory = folder_.string()});
    ASSERT_TRUE(opened.ok()) << opened.status();
    journal_ = *std::move(opened);
  }
  uint64_t Bytes() const { return BytesIn(folder_.string()); }
  // Waits until the journal takes no more than that; a minute is what it has. The missions that
  // stay may hold a written log beside the table made of it for a moment.
  bool Shrinks(uint64_t bytes) const {
    const absl::Time deadline = absl::Now() + absl::Minutes(1);
    while (Bytes() > bytes && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(50));
    return Bytes() <= bytes;
  }

  const fs::path folder_ = fs::path(::testing::TempDir()) / "journal_space_test" /
                           ::testing::UnitTest::GetInstance()->current_test_info()->name();
  std::unique_ptr<RocksJournal> journal_;
};

TEST_F(JournalSpaceTest, ADeletedMissionsDiskIsFreeAtOnce) {
  const MissionState state = MakeFeatureMission("a", kKeyframes, kFeatures);
  const uint64_t empty = Bytes();
  for (const char* name : {"a", "b", "c"}) {
    ASSERT_TRUE(journal_->CreateMission(name, state).ok());
    EXPECT_GT(journal_->DiskBytes(name), 8 * kMiB);
  }
  const uint64_t one = journal_->DiskBytes("b");
  ASSERT_TRUE(journal_->DeleteMission("a").ok());
  EXPECT_EQ(journal_->DiskBytes("a"), 0u);
  EXPECT_TRUE(Shrinks(empty + 5 * one / 2)) << Bytes() << ", one takes " << one;
  // Also of what was there at the start.
  Open();
  ASSERT_TRUE(journal_->DeleteMission("b").ok());
  ASSERT_TRUE(journal_->DeleteMission("c").ok());
  EXPECT_LT(Bytes(), empty + kMiB);
  EXPECT_TRUE(journal_->ListMissions()->empty());
}

// Returns a batch that removes all keyframes from `first` on.
BatchRecord RemoveFrom(uint32_t first) {
  auto batch = std::make_shared<MapUpdateBatch>();
  batch->local_map = LocalMapId{1};
  for (uint32_t i = first; i < kKeyframes; ++i) {
    batch->removed_keyframes.push_back({{LocalMapId{1}, i}, {LocalMapId{1}, 0}, Rigid3d()});
  }
  return {.agent = "a", .batch = batch, .received_at = absl::UnixEpoch()};
}

TEST_F(JournalSpaceTest, RemovedKeyframesGiveTheirDiskBack) {
  ASSERT_TRUE(journal_->CreateMission("a", MakeFeatureMission("a", kKeyframes, kFeatures)).ok());
  const uint64_t whole = journal_->DiskBytes("a");
  EXPECT_FALSE(journal_->WantsSnapshot("a"));
  // Few are not worth while.
  ASSERT_TRUE(journal_->Append("a", RemoveFrom(kKeyframes - 20)).ok());
  EXPECT_FALSE(journal_->WantsSnapshot("a"));
  const auto removed = journal_->Append("a", RemoveFrom(20));
  ASSERT_TRUE(removed.ok()) << removed.status();
  EXPECT_TRUE(journal_->WantsSnapshot("a"));
  JournalSnapshot snapshot = map_store::TakeSnapshot(MakeFeatureMission("a", 20, kFeatures));
  snapshot.position = *removed;
  ASSERT_TRUE(journal_->WriteSnapshot("a", snapshot).ok());
  EXPECT_FALSE(journal_->WantsSnapshot("a"));
  EXPECT_TRUE(Shrinks(whole / 5)) << Bytes() << " of " << whole;
  // What is still needed is there.
  Open();
  size_t keyframes = 0;
  Journal::Replay replay;
  replay.on_snapshot = [&](MissionState state) {
    for (const auto& [id, local_map] : state.local_maps) {
      for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
        keyframes += keyframe.keypoints().size() == kFeatures ? 1 : 0;
      }
    }
    return absl::OkStatus();
  };
  const auto recovered = journal_->Recover("a", replay);
  EXPECT_TRUE(recovered.ok()) << recovered.status();
  EXPECT_EQ(keyframes, 20u);
}

TEST(MissionContentsTest, KeepsCountOfWhatIsStillNeeded) {
  MissionContents contents;
  for (uint32_t i = 0; i < 4; ++i) contents.NoteFeatures({LocalMapId{1}, i}, i + 1, 16 * kMiB);
  contents.NoteRecord(4, 100);
  EXPECT_EQ(contents.live_bytes(), 64 * kMiB + 100);
  EXPECT_FALSE(contents.WantsSnapshot(32 * kMiB));
  contents.NoteRemoved({LocalMapId{1}, 0}, 5);
  EXPECT_FALSE(contents.WantsSnapshot(32 * kMiB)) << "a quarter is not more than a quarter";
  contents.NoteRemoved({LocalMapId{1}, 0}, 5);
  contents.NoteRemoved({LocalMapId{7}, 7}, 5);
  EXPECT_FALSE(contents.WantsSnapshot(32 * kMiB)) << "once only, and only what there is";
  contents.NoteRemoved({LocalMapId{1}, 1}, 6);
  EXPECT_TRUE(contents.WantsSnapshot(32 * kMiB));
  JournalSnapshot snapshot;
  snapshot.position = 5;
  snapshot.keyframes = {{LocalMapId{1}, 2}, {LocalMapId{1}, 1}};
  const std::vector<KeyframeId> unneeded = contents.FindUnneeded(snapshot);
  ASSERT_EQ(unneeded.size(), 2u);
  contents.NoteSnapshot(5, 10, unneeded);
  EXPECT_EQ(contents.live_bytes(), 32 * kMiB + 10);
  EXPECT_TRUE(contents.WantsSnapshot(32 * kMiB)) << "1 was removed since";
  contents.NoteSnapshot(6, 10, {});
  EXPECT_FALSE(contents.WantsSnapshot(32 * kMiB)) << "a snapshot that needs it has the last word";
}

}  // namespace
}  // namespace corbslam::map_store
