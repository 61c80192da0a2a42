// Stores with a journal on the disk, which are opened again and again.
#ifndef CORBSLAM_MAP_STORE_TESTING_ROCKS_STORE_H_
#define CORBSLAM_MAP_STORE_TESTING_ROCKS_STORE_H_

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"

namespace corbslam::testing {

class RocksStoreTest : public ::testing::Test {
 protected:
  static constexpr char kMission[] = "m";

  RocksStoreTest() {
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_);
  }
  ~RocksStoreTest() override { std::filesystem::remove_all(root_); }

  // Returns the folder of the mission's own database.
  static std::string MissionFolder(const std::string& folder) {
    return map_store::JournalFolder(folder).PathOf(kMission);
  }
  std::string Folder(const std::string& name) const { return (root_ / name).string(); }

  absl::StatusOr<std::unique_ptr<map_store::MapStore>> TryOpen(
      map_store::RocksJournalOptions options) {
    absl::StatusOr<std::unique_ptr<map_store::RocksJournal>> journal =
        map_store::RocksJournal::Open(options);
    if (!journal.ok()) return journal.status();
    auto store = std::make_unique<map_store::MapStore>(
        DeterministicOptions(), TheWorld().vocabulary, *std::move(journal), &worker_);
    const absl::Status recovered = store->Recover();
    if (!recovered.ok()) return recovered;
    return store;
  }
  std::unique_ptr<map_store::MapStore> Open(const map_store::RocksJournalOptions& options) {
    auto store = TryOpen(options);
    EXPECT_TRUE(store.ok()) << store.status();
    return store.ok() ? *std::move(store) : nullptr;
  }

  // Returns the batches of both robots in turn, as they would come.
  std::vector<MapUpdateBatch> MakeBatches() {
    map_store::MapStore scratch(DeterministicOptions(), nullptr,
                                std::make_unique<map_store::InMemoryJournal>(), nullptr);
    TestAgent a(scratch, "scratch", "a", map_a_);
    TestAgent b(scratch, "scratch", "b", map_b_);
    std::vector<MapUpdateBatch> batches;
    for (int i = 0; i < 14; ++i) {
      batches.push_back(a.NextBatch(1));
      batches.push_back(b.NextBatch(1));
    }
    return batches;
  }

  static uint64_t OpenSession(const std::string& agent, map_store::MapStore* store) {
    SessionRequest request;
    request.mission = kMission;
    request.agent = agent;
    return store->OpenSession(request)->session_id;
  }

  // Sends batches [begin, end) and fuses after each.
  static void Send(const std::vector<MapUpdateBatch>& batches, size_t begin, size_t end,
                   map_store::MapStore* store) {
    const uint64_t a = OpenSession("a", store);
    const uint64_t b = OpenSession("b", store);
    for (size_t i = begin; i < end; ++i) {
      const bool is_a = batches[i].local_map == LocalMapId{0xa};
      const auto acknowledged = store->Apply(is_a ? a : b, batches[i]);
      ASSERT_TRUE(acknowledged.ok()) << acknowledged.status();
      ASSERT_TRUE(store->RunFusionUntilIdle(kMission).ok());
    }
  }

  // Returns the number of the local map's last batch that the store has.
  static uint64_t LastBatch(const map_store::MapStore& store, LocalMapId id) {
    const auto info = store.GetLocalMap(kMission, id);
    return info.ok() ? info->last_batch : 0;
  }

  const std::filesystem::path root_ =
      std::filesystem::path(::testing::TempDir()) /
      ::testing::UnitTest::GetInstance()->current_test_suite()->name() /
      ::testing::UnitTest::GetInstance()->current_test_info()->name();
  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_ROCKS_STORE_H_
