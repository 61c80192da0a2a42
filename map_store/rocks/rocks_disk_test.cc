// Tests a journal on a disk that is full or slow.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/testing/rocks_store.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/unsynced_loss_env.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DumpLocal;
using ::testing::HasSubstr;
using testing::UnsyncedLossEnv;

class RocksDiskTest : public testing::RocksStoreTest {};

TEST_F(RocksDiskTest, AFullDiskIsSaidAndForgottenOnceThereIsRoom) {
  UnsyncedLossEnv env;
  const RocksJournalOptions options{.directory = Folder("store"), .env = &env};
  auto store = Open(options);
  const std::vector<MapUpdateBatch> batches = MakeBatches();
  Send(batches, 0, 4, store.get());
  const uint64_t session = OpenSession("a", store.get());
  env.SetFull(true);
  const auto full = store->Apply(session, batches[4]);
  EXPECT_EQ(full.status().code(), absl::StatusCode::kResourceExhausted) << full.status();
  EXPECT_THAT(std::string(full.status().message()), HasSubstr(options.directory));
  EXPECT_EQ(LastBatch(*store, {0xa}), 2u) << "nothing was stored";
  // Agents send a refused batch again and again.
  for (int i = 0; i < 25; ++i) {
    EXPECT_FALSE(store->Apply(session, batches[4]).ok());
    absl::SleepFor(absl::Milliseconds(100));
  }
  EXPECT_TRUE(absl::IsResourceExhausted(store->CheckWritable())) << store->CheckWritable();
  env.SetFull(false);
  auto again = store->Apply(session, batches[4]);
  const absl::Time deadline = absl::Now() + absl::Seconds(60);
  while (!again.ok() && absl::Now() < deadline) {
    EXPECT_EQ(again.status().code(), absl::StatusCode::kResourceExhausted) << again.status();
    absl::SleepFor(absl::Milliseconds(100));
    again = store->Apply(session, batches[4]);
  }
  EXPECT_TRUE(again.ok()) << again.status();
  const std::string local = DumpLocal(kMission, *store);
  store.reset();
  EXPECT_EQ(DumpLocal(kMission, *Open(options)), local);
}

// The store finds out without a batch to try it with.
TEST_F(RocksDiskTest, FindsOutByItselfThatThereIsRoomAgain) {
  UnsyncedLossEnv env;
  auto store = Open({.directory = Folder("store"), .env = &env});
  const std::vector<MapUpdateBatch> batches = MakeBatches();
  Send(batches, 0, 2, store.get());
  EXPECT_TRUE(store->CheckWritable().ok()) << store->CheckWritable();
  const uint64_t session = OpenSession("a", store.get());
  env.SetFull(true);
  EXPECT_FALSE(store->Apply(session, batches[2]).ok());
  EXPECT_FALSE(store->CheckWritable().ok());
  env.SetFull(false);
  const absl::Time deadline = absl::Now() + absl::Seconds(60);
  while (!store->CheckWritable().ok() && absl::Now() < deadline) {
    absl::SleepFor(absl::Milliseconds(100));
  }
  EXPECT_TRUE(store->CheckWritable().ok()) << store->CheckWritable();
  EXPECT_TRUE(store->Apply(session, batches[2]).ok());
}

TEST_F(RocksDiskTest, LeavesTheDiskItsReserve) {
  RocksJournalOptions options{.directory = Folder("store")};
  const std::vector<MapUpdateBatch> batches = MakeBatches();
  {
    auto store = Open(options);
    Send(batches, 0, 2, store.get());
  }
  options.min_free_bytes = fs::space(root_).capacity;
  auto store = Open(options);
  const absl::Status refused = store->Apply(OpenSession("a", store.get()), batches[2]).status();
  EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()), HasSubstr(absl::StrCat(options.min_free_bytes)));
  EXPECT_TRUE(absl::IsResourceExhausted(store->CheckWritable()));
  // A deletion makes room, so that it is not refused.
  EXPECT_TRUE(store->DeleteMission(kMission).ok());
}

// Returns a mission of many keyframes with features, and nothing else.
MissionState MakeLargeMission(uint32_t keyframes, size_t features) {
  MissionState state;
  state.name = "large";
  LocalMapState& local_map = map_store::AddLocalMap(state, LocalMapId{1}, "a");
  for (uint32_t i = 0; i < keyframes; ++i) {
    auto payload = std::make_shared<KeyframePayload>();
    payload->id = {local_map.id, i};
    payload->features.keypoints.resize(features);
    payload->features.descriptors.resize(features);
    Keyframe keyframe;
    keyframe.payload = std::move(payload);
    local_map.map.AddKeyframe(std::move(keyframe));
  }
  return state;
}

TEST_F(RocksDiskTest, ARestoreHoldsUpNobodysSync) {
  RocksJournalOptions options;
  options.directory = Folder("journal");
  auto journal = RocksJournal::Open(options);
  ASSERT_TRUE(journal.ok()) << journal.status();
  const MissionState large = MakeLargeMission(500, 2000);
  std::atomic<bool> restored = false;
  std::thread restore([&] {
    const absl::Status status = (*journal)->CreateMission("large", large);
    EXPECT_TRUE(status.ok()) << status;
    restored = true;
  });
  int synced_meanwhile = 0;
  while (!restored) {
    const auto position = (*journal)->Append(kMission, map_store::RederiveRecord());
    ASSERT_TRUE(position.ok() && (*journal)->Sync(kMission, *position).ok());
    synced_meanwhile += restored ? 0 : 1;
  }
  restore.join();
  EXPECT_GE(synced_meanwhile, 5);
}

TEST_F(RocksDiskTest, AFullDiskMakesNoMission) {
  UnsyncedLossEnv env;
  const RocksJournalOptions options{.directory = Folder("store"), .env = &env};
  auto store = Open(options);
  env.SetFull(true);
  EXPECT_FALSE(store->CreateMission("ahead", {}).ok());
  EXPECT_TRUE(absl::IsNotFound(store->GetMission("ahead").status()));
  env.SetFull(false);
  EXPECT_TRUE(store->CreateMission("ahead", {}).ok());
  store.reset();
  store = Open(options);
  EXPECT_TRUE(store->GetMission("ahead").ok());
}

}  // namespace
}  // namespace corbslam::map_store
