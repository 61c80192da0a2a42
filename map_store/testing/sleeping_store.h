// A store on a disk whose clock a test moves, and which counts what it reads and writes.
#ifndef CORBSLAM_MAP_STORE_TESTING_SLEEPING_STORE_H_
#define CORBSLAM_MAP_STORE_TESTING_SLEEPING_STORE_H_

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "absl/time/time.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/journal_wrapper.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::testing {

// Counts what passes through a CountingJournal; it outlives the journal.
struct JournalCounts {
  std::atomic<int> snapshots = 0;
  std::atomic<int> reads_with_features = 0;  // With features, as a store reads a mission.
  // Called, if not null, as such a reading begins.
  std::function<void(const std::string& mission)> on_read;
};

class CountingJournal : public JournalWrapper {
 public:
  CountingJournal(std::unique_ptr<map_store::Journal> journal, JournalCounts* counts)
      : JournalWrapper(std::move(journal)), counts_(*counts) {}

  absl::Status WriteSnapshot(absl::string_view mission,
                             const map_store::JournalSnapshot& snapshot) override {
    ++counts_.snapshots;
    return JournalWrapper::WriteSnapshot(mission, snapshot);
  }
  absl::StatusOr<Position> Recover(absl::string_view mission, const Replay& replay) const override {
    if (replay.with_features) {
      ++counts_.reads_with_features;
      if (counts_.on_read != nullptr) counts_.on_read(std::string(mission));
    }
    return JournalWrapper::Recover(mission, replay);
  }

 private:
  JournalCounts& counts_;
};

class SleepingStore : public ::testing::Test {
 protected:
  static constexpr char kMission[] = "m";

  SleepingStore() {
    options_.sleep_after_s = 600;
    std::filesystem::remove_all(folder_);
    Open();
  }
  ~SleepingStore() override {
    store_.reset();
    std::filesystem::remove_all(folder_);
  }

  // Opens the store, perhaps again, after an orderly end.
  void Open() {
    store_.reset();
    auto journal = map_store::RocksJournal::Open({.directory = folder_.string()});
    ASSERT_TRUE(journal.ok()) << journal.status();
    store_ = std::make_unique<map_store::MapStore>(
        options_, TheWorld().vocabulary,
        std::make_unique<CountingJournal>(*std::move(journal), &counts_), worker_,
        [this] { return now_; });
    ASSERT_TRUE(store_->Recover().ok());
  }
  // Streams one robot's map and ends its session.
  void Fill(const std::string& mission, const SyntheticMap& map) {
    TestAgent robot(*store_, mission, "robot", map);
    ASSERT_TRUE(robot.Stream().ok());
    ASSERT_TRUE(robot.Close().ok());
    store_->CloseSession(robot.session());
  }
  bool IsAsleep(const std::string& mission = kMission) {
    const auto info = store_->GetMission(mission);
    EXPECT_TRUE(info.ok()) << info.status();
    return info.ok() && info->asleep;
  }
  std::filesystem::path FolderOf(const std::string& mission = kMission) const {
    return map_store::JournalFolder(folder_.string()).PathOf(mission);
  }

  const std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / "sleeping_store" /
      ::testing::UnitTest::GetInstance()->current_test_info()->name();
  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker truthful_{{&map_a_, &map_b_}};
  FusionWorker* worker_ = nullptr;
  map_store::MapStoreOptions options_ = DeterministicOptions();
  absl::Time now_ = absl::UnixEpoch() + absl::Hours(1);  // Of deterministic stores.
  JournalCounts counts_;
  std::unique_ptr<map_store::MapStore> store_;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_SLEEPING_STORE_H_
