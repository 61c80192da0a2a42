#include "client_agent/upload/upload_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client_agent/spool/testing/fake_spool.h"
#include "client_agent/upload/spooled_map_reading.h"
#include "slam/camera/testing/test_camera.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr LocalMapId kMap{7};

MapUpdateBatch BatchOf(LocalMapId local_map) {
  MapUpdateBatch batch;
  batch.local_map = local_map;
  batch.lost_frames_ns = {1, 2, 3};
  return batch;
}

class UploadQueueTest : public ::testing::Test {
 protected:
  void Open(size_t max_memory_bytes) {
    queue_.reset();
    queue_ = std::make_unique<UploadQueue>(max_memory_bytes, *OpenFakeSpool(&disk_));
  }
  void Push(LocalMapId local_map, int count) {
    for (int i = 0; i < count; ++i) {
      queue_->Push(BatchOf(local_map));
      queue_->Spill();
    }
  }
  // Returns "local map/number" of all that is to be sent.
  std::vector<std::string> SendAll() {
    std::vector<std::string> sent;
    while (const auto batch = queue_->TakeUnsent(lost_)) {
      sent.push_back(absl::StrCat(batch->local_map.value, "/", batch->number,
                                  batch->closes_local_map ? " closes" : ""));
    }
    return sent;
  }

  FakeDisk disk_;
  std::unique_ptr<UploadQueue> queue_;
  std::vector<LostLocalMap> lost_;
};

TEST_F(UploadQueueTest, TheOldestBatchesGoToTheDisk) {
  Open(200);
  Push(kMap, 5);
  const UploadStatus status = queue_->status();
  EXPECT_TRUE(status.room.ok()) << status.room;
  EXPECT_LT(status.memory_bytes, 200u);
  EXPECT_GT(status.memory_bytes, 0u);
  EXPECT_LT(status.spool_bytes, disk_.Used());
  EXPECT_GT(status.spool_bytes, 0u);
  EXPECT_EQ(status.batches, 5u);
  EXPECT_GT(disk_.syncs, 0);
  EXPECT_THAT(SendAll(), ElementsAre("7/1", "7/2", "7/3", "7/4", "7/5"));
}

TEST_F(UploadQueueTest, WithoutMemoryEverythingIsOnDiskAtOnce) {
  Open(0);
  Push(kMap, 2);
  EXPECT_EQ(queue_->status().memory_bytes, 0u);
  EXPECT_THAT(SendAll(), ElementsAre("7/1", "7/2"));
}

TEST_F(UploadQueueTest, AcknowledgedBatchesGiveTheirRoomBack) {
  Open(0);
  Push(kMap, 3);
  SendAll();
  queue_->Acknowledge({kMap, 3});
  queue_->Spill();
  EXPECT_TRUE(queue_->IsEmpty());
  EXPECT_TRUE(disk_.files.empty());
  EXPECT_EQ(queue_->status().spool_bytes, 0u);
}

// A file goes as a whole: it stays for one batch that waits.
TEST_F(UploadQueueTest, TheSpoolsBytesAreThoseOfWhatWaits) {
  Open(0);
  Push(kMap, 3);
  SendAll();
  const uint64_t all = queue_->status().spool_bytes;
  const uint64_t on_disk = disk_.Used();
  queue_->Acknowledge({kMap, 2});
  queue_->Spill();
  EXPECT_GT(queue_->status().spool_bytes, 0u);
  EXPECT_LT(queue_->status().spool_bytes, all / 2);
  EXPECT_EQ(disk_.Used(), on_disk);
}

TEST_F(UploadQueueTest, AFullDiskIsSaidAndOnlyStopsTheTaking) {
  Open(200);
  disk_.capacity = 300;
  int pushed = 0;
  while (queue_->HasRoom() && pushed < 100) {
    Push(kMap, 1);
    ++pushed;
  }
  EXPECT_LT(pushed, 20);
  EXPECT_TRUE(absl::IsResourceExhausted(queue_->status().room)) << queue_->status().room;
  // Nothing is lost, and sending goes on.
  EXPECT_EQ(SendAll().size(), static_cast<size_t>(pushed));
  queue_->Acknowledge({kMap, static_cast<uint64_t>(pushed)});
  queue_->Spill();
  EXPECT_TRUE(queue_->HasRoom());
  EXPECT_TRUE(queue_->status().room.ok()) << queue_->status().room;
}

TEST_F(UploadQueueTest, WhatTheDiskDidNotConfirmStaysInMemory) {
  Open(0);
  Push(kMap, 1);
  disk_.sync_fails = true;
  Push(kMap, 1);
  EXPECT_GT(queue_->status().memory_bytes, 0u);
  EXPECT_FALSE(queue_->status().room.ok());
  disk_.sync_fails = false;
  queue_->Spill();
  EXPECT_EQ(disk_.files.size(), 2u) << "nothing goes behind what may be torn";
  EXPECT_EQ(queue_->status().memory_bytes, 0u);
  EXPECT_TRUE(queue_->status().room.ok());
  EXPECT_THAT(SendAll(), ElementsAre("7/1", "7/2"));
  Open(0);
  EXPECT_EQ(queue_->status().batches, 2u) << "each once";
}

TEST_F(UploadQueueTest, TheNextProcessDrainsWhatItFindsAndClosesIt) {
  Open(0);
  Push(kMap, 2);
  Open(1000);
  const LocalMapId own{8};
  EXPECT_TRUE(queue_->Begin(own));
  EXPECT_FALSE(queue_->Begin(kMap)) << "the id is taken";
  Push(own, 1);
  EXPECT_THAT(queue_->local_maps(), ElementsAre(kMap, own));
  EXPECT_TRUE(queue_->Resume({{{kMap, 1}, {own, 0}}}).empty());
  EXPECT_THAT(SendAll(), ElementsAre("7/2", "8/1", "7/3 closes"));
  queue_->Acknowledge({kMap, 3});
  queue_->Spill();
  EXPECT_TRUE(disk_.files.empty());
  EXPECT_THAT(queue_->local_maps(), ElementsAre(own));
}

TEST_F(UploadQueueTest, ClosesAfterWhatTheEarlierProcessSentButDidNotSpill) {
  Open(0);
  Push(kMap, 2);
  Open(0);
  EXPECT_TRUE(queue_->Resume({{{kMap, 6}}}).empty());
  EXPECT_THAT(SendAll(), ElementsAre("7/7 closes"));
}

TEST_F(UploadQueueTest, AClosedLocalMapIsNotClosedAgain) {
  Open(0);
  MapUpdateBatch last = BatchOf(kMap);
  last.closes_local_map = true;
  queue_->Push(last);
  queue_->Spill();
  Open(0);
  EXPECT_TRUE(queue_->Resume({{{kMap, 0}}}).empty());
  EXPECT_THAT(SendAll(), ElementsAre("7/1 closes"));
}

TEST_F(UploadQueueTest, AStoreThatLostAcknowledgedBatchesIsDataLoss) {
  Open(1000);
  EXPECT_TRUE(queue_->Begin(kMap));
  Push(kMap, 3);
  SendAll();
  queue_->Acknowledge({kMap, 2});
  const std::vector<LostLocalMap> lost = queue_->Resume({{{kMap, 1}}});
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_EQ(lost[0].id, kMap);
  EXPECT_FALSE(lost[0].of_earlier_process);
  EXPECT_TRUE(absl::IsDataLoss(lost[0].reason));
  EXPECT_THAT(std::string(lost[0].reason.message()), HasSubstr("only up to batch 1 of 2"));
  EXPECT_TRUE(absl::IsDataLoss(queue_->status().loss));
  EXPECT_EQ(queue_->status().lost_local_maps, 1);
  // The local map's batches could never be applied.
  EXPECT_TRUE(queue_->IsEmpty());
  Push(kMap, 1);
  EXPECT_TRUE(queue_->IsEmpty());
  EXPECT_TRUE(queue_->local_maps().empty());
}

TEST_F(UploadQueueTest, AStoreThatLostWhatItAcknowledgedToAnEarlierProcessIsDataLoss) {
  {
    const auto spool = *OpenFakeSpool(&disk_, {.owner = "", .segment_bytes = 1});
    MapUpdateBatch batch = BatchOf(kMap);
    // Batches 1 and 2 were acknowledged.
    for (batch.number = 3; batch.number <= 4; ++batch.number) {
      ASSERT_TRUE(spool->Append(batch).ok());
    }
  }
  Open(0);
  const std::vector<LostLocalMap> lost = queue_->Resume({{{kMap, 1}}});
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_TRUE(lost[0].of_earlier_process);
  EXPECT_TRUE(absl::IsDataLoss(lost[0].reason));
  EXPECT_TRUE(queue_->IsEmpty());
}

TEST_F(UploadQueueTest, AnIdThatTheStoreKnowsFromElsewhereIsTaken) {
  Open(1000);
  EXPECT_TRUE(queue_->Begin(kMap));
  Push(kMap, 1);
  const std::vector<LostLocalMap> lost = queue_->Resume({{{kMap, 9}}});
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_TRUE(absl::IsAlreadyExists(lost[0].reason)) << lost[0].reason;
}

TEST_F(UploadQueueTest, ABatchThatTheDiskLostGivesItsLocalMapUp) {
  Open(0);
  Push(kMap, 2);
  Push({8}, 1);
  disk_.files.begin()->second[60] ^= 1;  // The byte is in the first batch.
  EXPECT_THAT(SendAll(), ElementsAre("8/1"));
  ASSERT_EQ(lost_.size(), 1u);
  EXPECT_EQ(lost_[0].id, kMap);
  EXPECT_TRUE(absl::IsDataLoss(queue_->status().loss));
}

TEST_F(UploadQueueTest, DamageInTheMiddleIsSaidAndTheRestLeftOut) {
  const auto write = [this] {
    const auto spool = *OpenFakeSpool(&disk_, {.owner = "", .segment_bytes = 1});
    for (uint64_t number = 1; number <= 3; ++number) {
      MapUpdateBatch batch = BatchOf(kMap);
      batch.number = number;
      ASSERT_TRUE(spool->Append(batch).ok());
    }
  };
  write();
  disk_.files["000000000002.spool"].back() ^= 1;
  Open(0);
  EXPECT_TRUE(absl::IsDataLoss(queue_->status().loss));
  EXPECT_TRUE(queue_->Resume({{{kMap, 0}}}).empty());
  EXPECT_THAT(SendAll(), ElementsAre("7/1", "7/2 closes"));
}

TEST_F(UploadQueueTest, WhatTheStoreRefusesOfAnEarlierProcessIsSetAside) {
  Open(0);
  Push(kMap, 2);
  Open(0);
  EXPECT_TRUE(queue_->Begin({8}));
  Push({8}, 1);
  EXPECT_TRUE(queue_->GiveUpEarlier(absl::InvalidArgumentError("NaN")));
  EXPECT_THAT(SendAll(), ElementsAre("8/1"));
  EXPECT_TRUE(absl::IsDataLoss(queue_->status().loss));
  EXPECT_FALSE(queue_->GiveUpEarlier(absl::InvalidArgumentError("NaN"))) << "that one is our own";
}

TEST_F(UploadQueueTest, WhatTheStoreRefusesTwiceOfThisProcessIsGivenUp) {
  Open(1 << 20);
  EXPECT_TRUE(queue_->Begin(kMap));
  EXPECT_FALSE(queue_->NoteRefusal(absl::InvalidArgumentError("NaN"))) << "nothing was sent";
  Push(kMap, 3);
  EXPECT_THAT(SendAll(), ElementsAre("7/1", "7/2", "7/3"));
  EXPECT_TRUE(queue_->NoteRefusal(absl::InvalidArgumentError("NaN")));
  // The store had taken the first batch: it meant a later one.
  EXPECT_TRUE(queue_->Resume({{{kMap, 1}}}).empty());
  EXPECT_THAT(SendAll(), ElementsAre("7/2", "7/3"));
  EXPECT_TRUE(queue_->NoteRefusal(absl::InvalidArgumentError("NaN")));
  const std::vector<LostLocalMap> lost = queue_->Resume({{{kMap, 1}}});
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_EQ(lost[0].id, kMap);
  EXPECT_FALSE(lost[0].of_earlier_process);
  EXPECT_TRUE(absl::IsDataLoss(queue_->status().loss));
  EXPECT_EQ(queue_->status().lost_local_maps, 1);
  EXPECT_TRUE(queue_->IsEmpty());
}

// Tests a queue with a disk that is to have everything.
class DurableQueueTest : public UploadQueueTest {
 protected:
  void OpenDurable(bool keep = false, LocalMapId goes_on = {}) {
    queue_.reset();
    UploadQueueOptions options;
    options.write_all = true;
    options.keep = keep;
    options.goes_on = goes_on;
    options.snapshot_after_bytes = 2000;
    options.snapshot_at_once = true;
    SpoolOptions spool;
    spool.segment_bytes = 500;
    queue_ = std::make_unique<UploadQueue>(options, *OpenFakeSpool(&disk_, spool));
  }
  // Returns "local map/number" of what the next process finds.
  std::vector<std::string> FindAll() {
    std::vector<std::string> found;
    FakeDisk copy = disk_;
    const auto spool = *OpenFakeSpool(&copy);
    for (const SpooledBatch& spooled : spool->found()) {
      if (spooled.record.kind != SpoolRecord::Kind::kBatch) continue;
      found.push_back(absl::StrCat(spooled.record.local_map.value, "/", spooled.record.number));
    }
    return found;
  }
};

TEST_F(DurableQueueTest, WhatIsPushedIsInMemoryAndOnTheDisk) {
  OpenDurable();
  ASSERT_TRUE(queue_->Begin(kMap));
  Push(kMap, 3);
  EXPECT_GT(queue_->status().memory_bytes, 0u);
  EXPECT_THAT(FindAll(), ElementsAre("7/1", "7/2", "7/3"));
  EXPECT_THAT(SendAll(), ElementsAre("7/1", "7/2", "7/3"));
}

// The next process learns from the last batch that the local map is to be closed.
TEST_F(DurableQueueTest, TheLastBatchStaysUntilTheLocalMapIsClosed) {
  OpenDurable();
  ASSERT_TRUE(queue_->Begin(kMap));
  Push(kMap, 3);
  SendAll();
  queue_->Acknowledge({kMap, 3});
  queue_->Spill();
  EXPECT_FALSE(disk_.files.empty());
  OpenDurable();
  EXPECT_TRUE(queue_->Resume({{{kMap, 3}}}).empty());
  queue_->Spill();
  EXPECT_THAT(SendAll(), ElementsAre("7/4 closes"));
  queue_->Acknowledge({kMap, 4});
  queue_->Spill();
  EXPECT_TRUE(disk_.files.empty());
}

TEST_F(DurableQueueTest, AFullDiskIsSaidAndStopsNothing) {
  OpenDurable();
  ASSERT_TRUE(queue_->Begin(kMap));
  Push(kMap, 1);
  disk_.capacity = disk_.Used() + 10;
  Push(kMap, 5);
  EXPECT_TRUE(absl::IsResourceExhausted(queue_->status().durable)) << queue_->status().durable;
  EXPECT_TRUE(queue_->status().room.ok()) << "memory has room";
  EXPECT_EQ(SendAll().size(), 6u);
  disk_.capacity = 1 << 20;
  queue_->Spill();
  EXPECT_TRUE(queue_->status().durable.ok());
  EXPECT_EQ(FindAll().size(), 6u);
}

TEST_F(DurableQueueTest, WhatIsKeptStaysAndGoesOn) {
  OpenDurable(/*keep=*/true);
  ASSERT_TRUE(queue_->Begin(kMap));
  Push(kMap, 3);
  SendAll();
  queue_->Acknowledge({kMap, 3});
  queue_->Spill();
  EXPECT_THAT(FindAll(), ElementsAre("7/1", "7/2", "7/3"));
  OpenDurable(/*keep=*/true, kMap);
  ASSERT_TRUE(queue_->Begin(kMap));
  EXPECT_TRUE(queue_->Resume({{{kMap, 3}}}).empty());
  Push(kMap, 1);
  EXPECT_THAT(SendAll(), ElementsAre("7/4")) << "it is not closed";
  queue_->Acknowledge({kMap, 4});
  queue_->Spill();
  EXPECT_THAT(FindAll(), ElementsAre("7/1", "7/2", "7/3", "7/4"));
  // Another one follows: the first is kept no more, but for what it is closed by.
  ASSERT_TRUE(queue_->Begin(LocalMapId{8}));
  MapUpdateBatch last = BatchOf(kMap);
  last.closes_local_map = true;
  queue_->Push(last);
  queue_->Spill();
  SendAll();
  queue_->Acknowledge({kMap, 5});
  queue_->Spill();
  EXPECT_TRUE(disk_.files.empty());
}

TEST_F(DurableQueueTest, WhatIsNotOnTheDiskIsNotSentWhereItIsKept) {
  OpenDurable(/*keep=*/true);
  ASSERT_TRUE(queue_->Begin(kMap));
  disk_.sync_fails = true;
  Push(kMap, 1);
  EXPECT_THAT(SendAll(), ElementsAre());
  disk_.sync_fails = false;
  queue_->Spill();
  EXPECT_THAT(SendAll(), ElementsAre("7/1"));
}

TEST_F(DurableQueueTest, AStoreThatHasMoreThanTheDiskCannotGoOn) {
  OpenDurable(/*keep=*/true);
  ASSERT_TRUE(queue_->Begin(kMap));
  Push(kMap, 2);
  OpenDurable(/*keep=*/true, kMap);
  ASSERT_TRUE(queue_->Begin(kMap));
  const std::vector<LostLocalMap> lost = queue_->Resume({{{kMap, 3}}});
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_TRUE(absl::IsDataLoss(lost[0].reason));
  EXPECT_THAT(std::string(lost[0].reason.message()), HasSubstr("only up to batch 2"));
}

// What is spooled does not grow without end, and is read as before.
TEST_F(DurableQueueTest, WhatIsKeptIsWrittenAsAWhole) {
  OpenDurable(/*keep=*/true);
  ASSERT_TRUE(queue_->Begin(kMap));
  MapUpdateBatch first = BatchOf(kMap);
  first.cameras.push_back(testing::TestCamera());
  Features features;
  features.keypoints.resize(1);
  features.descriptors.resize(1);
  first.full_keyframes.push_back(
      {MakeKeyframePayload({kMap, 0}, 1, 0, testing::TestCamera(), std::move(features)),
       Rigid3d::Identity(),
       {}});
  queue_->Push(first);
  for (uint64_t number = 2; number <= 400; ++number) {
    MapUpdateBatch next = BatchOf(kMap);
    next.light_keyframes.push_back({{kMap, 0}, Rigid3d::Identity(), {}});
    next.light_keyframes[0].camera_from_local.translation.x() = static_cast<double>(number);
    queue_->Push(next);
    queue_->Spill();
    SendAll();
    queue_->Acknowledge({kMap, number});
  }
  queue_->Spill();
  EXPECT_LT(FindAll().size(), 200u);
  OpenDurable();
  FakeDisk copy = disk_;
  const auto spool = *OpenFakeSpool(&copy);
  const absl::StatusOr<SpooledMap> spooled_map = ReadNewestSpooledMap(*spool);
  ASSERT_TRUE(spooled_map.ok()) << spooled_map.status();
  EXPECT_EQ(spooled_map->keyframes().at({kMap, 0}).camera_from_local.translation.x(), 400);
  // Nor is it a loss for who goes on with it.
  OpenDurable(/*keep=*/true, kMap);
  EXPECT_EQ(queue_->status().lost_local_maps, 0);
  ASSERT_TRUE(queue_->Begin(kMap));
  EXPECT_TRUE(queue_->Resume({{{kMap, 400}}}).empty());
  Push(kMap, 1);
  EXPECT_THAT(SendAll(), ElementsAre("7/401"));
}

}  // namespace
}  // namespace corbslam::client_agent
