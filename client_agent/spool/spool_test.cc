#include "client_agent/spool/spool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "client_agent/spool/testing/fake_spool.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

MapUpdateBatch BatchOf(uint64_t local_map, uint64_t number, size_t frames = 3) {
  MapUpdateBatch batch;
  batch.local_map = {local_map};
  batch.number = number;
  batch.lost_frames_ns.resize(frames, static_cast<int64_t>(number));
  return batch;
}

class SpoolTest : public ::testing::Test {
 protected:
  std::unique_ptr<Spool> Open() {
    auto spool = OpenFakeSpool(&disk_, options_);
    EXPECT_TRUE(spool.ok()) << spool.status();
    return *std::move(spool);
  }
  // Writes `count` batches of local map 7 in one process that then ends.
  void Write(uint64_t count) {
    const auto spool = Open();
    for (uint64_t number = 1; number <= count; ++number) {
      ASSERT_TRUE(spool->Append(BatchOf(7, number)).ok());
    }
    ASSERT_TRUE(spool->Sync().ok());
  }
  std::string& OnlyFile() {
    EXPECT_EQ(disk_.files.size(), 1u);
    return disk_.files.begin()->second;
  }

  FakeDisk disk_;
  SpoolOptions options_ = SpoolOptions{.owner = "missions/m/agents/alpha"};
};

TEST_F(SpoolTest, WhatWasAppendedIsReadAgain) {
  const auto spool = Open();
  const auto first = spool->Append(BatchOf(7, 1));
  const auto second = spool->Append(BatchOf(8, 5, 1000));
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_EQ(spool->Read(*second)->lost_frames_ns.size(), 1000u);
  EXPECT_EQ(spool->Read(*first)->local_map, LocalMapId{7});
}

TEST_F(SpoolTest, TheNextProcessFindsItInOrder) {
  Write(3);
  const auto spool = Open();
  const std::vector<SpooledBatch> found = spool->TakeFound();
  ASSERT_EQ(found.size(), 3u);
  for (uint64_t i = 0; i < 3; ++i) {
    EXPECT_EQ(found[i].record.number, i + 1);
    EXPECT_EQ(spool->Read(found[i])->lost_frames_ns[0], static_cast<int64_t>(i + 1));
  }
  EXPECT_TRUE(spool->TakeFound().empty());
}

TEST_F(SpoolTest, SegmentsGoWhenNothingInThemIsNeeded) {
  options_.segment_bytes = 1;  // Each segment holds one batch.
  const auto spool = Open();
  const auto first = *spool->Append(BatchOf(7, 1));
  const auto second = *spool->Append(BatchOf(7, 2));
  EXPECT_EQ(disk_.files.size(), 2u);
  spool->Release(first);
  EXPECT_EQ(disk_.files.size(), 1u);
  EXPECT_EQ(spool->bytes(), disk_.Used());
  spool->Release(second);
  EXPECT_TRUE(disk_.files.empty());
  EXPECT_EQ(spool->bytes(), 0u);
  // The spool begins again.
  EXPECT_TRUE(spool->Read(*spool->Append(BatchOf(7, 3))).ok());
}

// Whatever byte the tail is cut at, the whole batches before it are there, and nothing else.
TEST_F(SpoolTest, ATornTailIsLeftOut) {
  Write(3);
  const std::string whole = OnlyFile();
  const size_t record = [&] {
    const auto spool = Open();
    return spool->TakeFound()[0].record.bytes;
  }();
  const size_t header = whole.size() - 3 * record;
  for (size_t size = 0; size < whole.size(); ++size) {
    disk_.files = {{"000000000001.spool", whole.substr(0, size)}};
    const auto spool = Open();
    const size_t expected = size < header ? 0 : (size - header) / record;
    ASSERT_EQ(spool->TakeFound().size(), expected) << "cut at " << size;
  }
}

TEST_F(SpoolTest, FlippedBitsNeverPassForABatch) {
  Write(3);
  const std::string whole = OnlyFile();
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    std::string& content = disk_.files["000000000001.spool"] = whole;
    content[random() % content.size()] ^= static_cast<char>(1 << (random() % 8));
    const auto spool = OpenFakeSpool(&disk_, options_);
    if (!spool.ok()) {
      EXPECT_TRUE(absl::IsFailedPrecondition(spool.status())) << spool.status();
      continue;
    }
    const std::vector<SpooledBatch> found = (*spool)->TakeFound();
    EXPECT_LT(found.size(), 3u);
    for (size_t k = 0; k < found.size(); ++k) {
      EXPECT_EQ((*spool)->Read(found[k])->lost_frames_ns[0], static_cast<int64_t>(k + 1));
    }
  }
}

TEST_F(SpoolTest, ABatchThatTheDiskLostLaterIsDataLoss) {
  const auto spool = Open();
  const auto batch = *spool->Append(BatchOf(7, 1));
  OnlyFile().back() ^= 1;
  EXPECT_TRUE(absl::IsDataLoss(spool->Read(batch).status()));
}

TEST_F(SpoolTest, AFullDiskLeavesTheSpoolAsItWas) {
  const auto spool = Open();
  const auto first = *spool->Append(BatchOf(7, 1));
  const size_t used = disk_.Used();
  disk_.capacity = used + 40;  // A part of the next record fits.
  EXPECT_TRUE(absl::IsResourceExhausted(spool->Append(BatchOf(7, 2)).status()));
  EXPECT_EQ(disk_.Used(), used);
  EXPECT_EQ(spool->bytes(), used);
  disk_.capacity = 1 << 20;
  const auto second = spool->Append(BatchOf(7, 2));
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_TRUE(spool->Read(first).ok());
  EXPECT_TRUE(spool->Read(*second).ok());
  EXPECT_EQ(Open()->TakeFound().size(), 2u);
}

TEST_F(SpoolTest, ItsOwnBoundIsNamed) {
  options_.max_bytes = 500;
  const auto spool = Open();
  absl::Status status;
  int appended = 0;
  for (; status.ok() && appended < 100; ++appended) {
    status = spool->Append(BatchOf(7, static_cast<uint64_t>(appended) + 1)).status();
  }
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("limit is 500"));
  EXPECT_LE(disk_.Used(), 500u);
  EXPECT_GT(appended, 1);
}

TEST_F(SpoolTest, SomebodyElsesFolderIsRefusedByName) {
  Write(1);
  options_.owner = "missions/m/agents/beta";
  const absl::Status status = OpenFakeSpool(&disk_, options_).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("belongs to missions/m/agents/alpha"));
  // The folder is left alone.
  EXPECT_EQ(disk_.files.size(), 1u);
}

TEST_F(SpoolTest, ANewerVersionIsRefusedByName) {
  Write(1);
  OnlyFile()[7] = '4';
  const absl::Status status = OpenFakeSpool(&disk_, options_).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("version '4'"));
}

TEST_F(SpoolTest, AnOlderVersionIsRead) {
  Write(2);
  ASSERT_EQ(OnlyFile()[7], '3');
  for (const char version : {'1', '2'}) {
    OnlyFile()[7] = version;
    const auto spool = Open();
    const std::vector<SpooledBatch> found = spool->TakeFound();
    ASSERT_EQ(found.size(), 2u) << version;
    EXPECT_TRUE(spool->Read(found[1]).ok());
  }
}

TEST_F(SpoolTest, TheKindOfARecordIsKept) {
  using Kind = SpoolRecord::Kind;
  const std::vector<Kind> kinds = {Kind::kBatch, Kind::kSnapshotPart, Kind::kSnapshotEnd,
                                   Kind::kHeldBackKeyframe, Kind::kHeldBackRest};
  {
    const auto spool = Open();
    for (const Kind kind : kinds) ASSERT_TRUE(spool->Append(BatchOf(7, 1), kind).ok());
  }
  std::vector<Kind> found;
  const auto spool = Open();
  for (const SpooledBatch& spooled : spool->found()) found.push_back(spooled.record.kind);
  EXPECT_EQ(found, kinds);
}

// The disk keeps what was synced, and any part of what was written since.
TEST_F(SpoolTest, WhatWasSyncedOutlivesALossOfPower) {
  options_.segment_bytes = 500;
  std::mt19937 random(3);
  size_t lost = 0;
  for (int cut = 0; cut < 200; ++cut) {
    disk_ = FakeDisk();
    size_t synced = 0;
    {
      const auto spool = Open();
      for (uint64_t number = 1; number <= 12; ++number) {
        ASSERT_TRUE(spool->Append(BatchOf(7, number)).ok());
        if (random() % 4 != 0) continue;
        ASSERT_TRUE(spool->Sync().ok());
        ASSERT_EQ(spool->synced(), number);
        synced = number;
      }
    }
    disk_.CutPower(random);
    const auto spool = Open();
    const std::vector<SpooledBatch> found = spool->TakeFound();
    ASSERT_GE(found.size(), synced) << "cut " << cut;
    for (size_t i = 0; i < found.size(); ++i) ASSERT_EQ(found[i].record.number, i + 1);
    lost += 12 - found.size();
  }
  EXPECT_GT(lost, 0u) << "the test can't tell";
}

// The first batch is needed until the disk has the second for certain.
TEST_F(SpoolTest, WhatSomethingStandsInForGoesOnceThatIsSynced) {
  options_.segment_bytes = 1;  // A batch in each.
  options_.sync = SyncPolicy{.after = absl::Hours(1), .bytes = 1 << 30};
  const auto spool = Open();
  const SpooledBatch before = *spool->Append(BatchOf(7, 1));
  ASSERT_TRUE(spool->Sync().ok());
  ASSERT_TRUE(spool->Append(BatchOf(7, 2)).ok());
  spool->ReleaseOnceSynced(before);
  EXPECT_EQ(disk_.files.size(), 2u);
  disk_.sync_fails = true;
  EXPECT_FALSE(spool->Sync().ok());
  disk_.sync_fails = false;
  // Another one is synced, and what stands in is not appended again yet.
  EXPECT_EQ(disk_.files.size(), 2u);
  ASSERT_TRUE(spool->Append(BatchOf(7, 2)).ok());
  EXPECT_EQ(disk_.files.size(), 3u);
  ASSERT_TRUE(spool->Sync().ok());
  EXPECT_EQ(disk_.files.size(), 2u) << "the first one's is gone";
  const auto again = OpenFakeSpool(&disk_, {.owner = options_.owner});
  for (const SpooledBatch& found : (*again)->found()) EXPECT_EQ(found.record.number, 2u);
}

TEST_F(SpoolTest, AThreadSyncsWhatIsWritten) {
  const std::string path = ::testing::TempDir() + "/spool_thread_test";
  std::filesystem::remove_all(path);
  options_.sync = SyncPolicy{.after = absl::Hours(1), .bytes = 1};
  auto spool = *Spool::Open(options_, *OpenSpoolFolder(path), FakeCodec(&disk_));
  for (uint64_t number = 1; number <= 20; ++number) {
    ASSERT_TRUE(spool->Append(BatchOf(7, number)).ok());
  }
  EXPECT_TRUE(spool->Sync().ok());
  EXPECT_EQ(spool->synced(), 20u);
  EXPECT_GE(spool->syncs(), 1u);
  spool.reset();
  std::filesystem::remove_all(path);
}

TEST_F(SpoolTest, WhatWasFoundIsNeverWrittenOn) {
  Write(1);
  const std::string before = OnlyFile();
  const auto spool = Open();
  ASSERT_TRUE(spool->Append(BatchOf(9, 1)).ok());
  EXPECT_EQ(disk_.files.size(), 2u);
  EXPECT_EQ(disk_.files.begin()->second, before);
}

TEST(SpoolFolderTest, KeepsBatchesInAFolder) {
  const std::string path = ::testing::TempDir() + "/spool_folder_test";
  std::filesystem::remove_all(path);
  FakeDisk codec_disk;
  const SpoolOptions options = {.owner = "me"};
  {
    auto files = OpenSpoolFolder(path);
    ASSERT_TRUE(files.ok()) << files.status();
    const absl::Status locked = OpenSpoolFolder(path).status();
    EXPECT_TRUE(absl::IsFailedPrecondition(locked)) << locked;
    EXPECT_THAT(std::string(locked.message()), HasSubstr("this process itself has it"));
    auto spool = Spool::Open(options, *std::move(files), FakeCodec(&codec_disk));
    ASSERT_TRUE((*spool)->Append(BatchOf(7, 1)).ok());
    ASSERT_TRUE((*spool)->Append(BatchOf(7, 2)).ok());
    ASSERT_TRUE((*spool)->Sync().ok());
  }
  auto spool = Spool::Open(options, *OpenSpoolFolder(path), FakeCodec(&codec_disk));
  ASSERT_TRUE(spool.ok()) << spool.status();
  const std::vector<SpooledBatch> found = (*spool)->TakeFound();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ((*spool)->Read(found[1])->number, 2u);
  std::filesystem::remove(path + "/000000000001.spool");
  EXPECT_TRUE(absl::IsDataLoss((*spool)->Read(found[1]).status())) << "it is gone for good";
  for (const SpooledBatch& batch : found) (*spool)->Release(batch);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path), {}), 1) << "the lock alone";
  std::filesystem::remove_all(path);
}

TEST(SpoolFolderTest, AFolderThatCannotBeIsNamed) {
  const absl::Status status = OpenSpoolFolder("/proc/no/such/spool").status();
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(std::string(status.message()), HasSubstr("/proc/no/such/spool"));
}

}  // namespace
}  // namespace corbslam::client_agent
