// Tests that snapshots are made from the journal, beside the robots' batches, and say what the
// mission said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "map_store/archive/state_archive.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::map_store {
namespace {

using testing::ByteJournal;
using testing::DeterministicOptions;
using testing::JournalBytes;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;

constexpr char kMission[] = "m";

// A journal that lets something happen when a replay begins.
class InterruptedJournal : public ByteJournal {
 public:
  explicit InterruptedJournal(std::shared_ptr<JournalBytes> bytes)
      : ByteJournal(std::move(bytes)) {}

  absl::StatusOr<Position> Recover(absl::string_view mission, const Replay& replay) const override {
    if (on_recover_) std::exchange(on_recover_, nullptr)();
    return ByteJournal::Recover(mission, replay);
  }
  void OnNextRecover(std::function<void()> action) { on_recover_ = std::move(action); }

 private:
  mutable std::function<void()> on_recover_;
};

class SnapshotTest : public ::testing::Test {
 protected:
  SnapshotTest() {
    auto journal = std::make_unique<InterruptedJournal>(bytes_);
    journal_ = journal.get();
    store_ = std::make_unique<MapStore>(DeterministicOptions(), TheWorld().vocabulary,
                                        std::move(journal), &worker_);
  }

  // Fuses; if the journal wants a snapshot, it is kept first.
  void Fuse() { ASSERT_TRUE(store_->RunFusionUntilIdle(kMission).ok()); }
  // Returns the mission as it stands, as a snapshot would have it.
  std::string Standing() {
    absl::StatusOr<MissionBackup> backup = store_->BackUpMission(kMission);
    MissionRestorer restorer = store_->StartRestoring();
    for (std::string piece = backup->Next(1 << 20); !piece.empty(); piece = backup->Next(1 << 20)) {
      EXPECT_TRUE(restorer.Add(piece).ok());
    }
    const auto state = restorer.Finish();
    EXPECT_TRUE(state.ok()) << state.status();
    return state.ok() ? map_store::EncodeState(*state) : "";
  }

  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
  std::shared_ptr<JournalBytes> bytes_ = std::make_shared<JournalBytes>();
  InterruptedJournal* journal_ = nullptr;
  std::unique_ptr<MapStore> store_;
};

TEST_F(SnapshotTest, SaysToTheByteWhatTheMissionSays) {
  TestAgent a(*store_, kMission, "a", map_a_);
  TestAgent b(*store_, kMission, "b", map_b_);
  for (int i = 0; i < 14; ++i) {
    ASSERT_TRUE(a.Send(a.NextBatch(1)).ok());
    ASSERT_TRUE(b.Send(b.NextBatch(1)).ok());
    Fuse();
    // Some snapshots follow one another closely, others have much between them.
    bytes_->wants_snapshot = i % 5 > 2;
    if (!bytes_->wants_snapshot) continue;
    Fuse();
    EXPECT_TRUE(bytes_->records.empty());
    EXPECT_TRUE(bytes_->snapshot == Standing()) << "after batch " << i;
  }
  EXPECT_GT(store_->GetStatistics(kMission)->revision, 1u);
  EXPECT_EQ(store_->GetStatistics(kMission)->islands, 1u);
}

TEST_F(SnapshotTest, BatchesGoOnWhileOneIsMade) {
  TestAgent a(*store_, kMission, "a", map_a_);
  ASSERT_TRUE(a.Send(a.NextBatch(3)).ok());
  bytes_->wants_snapshot = true;
  // The batch is sent on the same thread: if that held the strand, it would wait for ever.
  journal_->OnNextRecover([&a] { EXPECT_TRUE(a.Send(a.NextBatch(3)).ok()); });
  Fuse();
  // The batch that came meanwhile is behind the snapshot.
  EXPECT_FALSE(bytes_->snapshot.empty());
  EXPECT_EQ(bytes_->records.size(), 1u);
  const std::string local = testing::DumpLocal(kMission, *store_);
  MapStore again(DeterministicOptions(), TheWorld().vocabulary,
                 std::make_unique<ByteJournal>(bytes_), nullptr);
  ASSERT_TRUE(again.Recover().ok());
  EXPECT_EQ(testing::FirstDifference(testing::DumpLocal(kMission, again), local), "");
}

TEST_F(SnapshotTest, OneOfADeletedMissionIsGivenUp) {
  TestAgent a(*store_, kMission, "a", map_a_);
  ASSERT_TRUE(a.Send(a.NextBatch(3)).ok());
  bytes_->wants_snapshot = true;
  std::thread deleting;
  journal_->OnNextRecover([&] {
    deleting = std::thread([this] { EXPECT_TRUE(store_->DeleteMission(kMission).ok()); });
    while (a.Send(a.NextBatch(1)).ok()) absl::SleepFor(absl::Milliseconds(1));
  });
  store_->RunFusionUntilIdle(kMission).IgnoreError();
  deleting.join();
  EXPECT_TRUE(bytes_->snapshot.empty());
}

}  // namespace
}  // namespace corbslam::map_store
