// Tests a store that is killed at any moment, on a disk that keeps only what was synced.
#include "map_store/rocks/rocks_journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "map_store/rocks/durable_mark.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/rocks_store.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/unsynced_loss_env.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DumpGlobal;
using testing::DumpLocal;
using testing::DumpPlaces;
using ::testing::HasSubstr;
using testing::UnsyncedLossEnv;

class RocksJournalTest : public testing::RocksStoreTest {};

TEST_F(RocksJournalTest, AStoreOpenedAgainIsWhatItWas) {
  for (const uint64_t between_snapshots : {uint64_t{1} << 30, uint64_t{1}}) {
    const RocksJournalOptions options{.directory = Folder(absl::StrCat("store", between_snapshots)),
                                      .min_bytes_between_snapshots = between_snapshots};
    auto store = Open(options);
    const std::vector<MapUpdateBatch> batches = MakeBatches();
    Send(batches, 0, batches.size(), store.get());
    ASSERT_EQ(store->GetStatistics(kMission)->islands, 1u);
    ASSERT_GT(store->GetStatistics(kMission)->revision, 1u);
    const std::string local = DumpLocal(kMission, *store);
    const std::string global = DumpGlobal(kMission, *store);
    store.reset();
    store = Open(options);
    EXPECT_EQ(DumpLocal(kMission, *store), local) << between_snapshots;
    EXPECT_EQ(DumpGlobal(kMission, *store), global) << between_snapshots;
  }
}

// Wherever the stream is cut, what was done before and after the restart makes the undisturbed map.
TEST_F(RocksJournalTest, AStoreThatWasRestartedEndsWithTheSameLocalLayer) {
  const std::vector<MapUpdateBatch> batches = MakeBatches();
  auto undisturbed = Open({.directory = Folder("undisturbed")});
  Send(batches, 0, batches.size(), undisturbed.get());
  for (const size_t cut : {1u, 9u, 16u, 27u}) {
    const RocksJournalOptions options{.directory = Folder(absl::StrCat("cut", cut)),
                                      .min_bytes_between_snapshots = 200000};
    auto store = Open(options);
    Send(batches, 0, cut, store.get());
    store.reset();
    store = Open(options);
    Send(batches, cut, batches.size(), store.get());
    EXPECT_EQ(DumpLocal(kMission, *store), DumpLocal(kMission, *undisturbed)) << cut;
    EXPECT_EQ(store->GetStatistics(kMission)->islands, 1u) << cut;
  }
}

// Batches in another order, with a restart in between, are derived to the same map.
TEST_F(RocksJournalTest, TheSameLocalLayerIsDerivedToTheSameGlobalLayer) {
  const std::vector<MapUpdateBatch> batches = MakeBatches();
  auto undisturbed = Open({.directory = Folder("undisturbed")});
  Send(batches, 0, batches.size(), undisturbed.get());
  const RocksJournalOptions options{.directory = Folder("other")};
  auto other = Open(options);
  std::vector<MapUpdateBatch> one_after_the_other = batches;
  std::stable_sort(one_after_the_other.begin(), one_after_the_other.end(),
                   [](const auto& a, const auto& b) { return a.local_map < b.local_map; });
  Send(one_after_the_other, 0, 9, other.get());
  other.reset();
  other = Open(options);
  Send(one_after_the_other, 9, batches.size(), other.get());
  ASSERT_EQ(DumpLocal(kMission, *other), DumpLocal(kMission, *undisturbed));

  for (MapStore* store : {undisturbed.get(), other.get()}) {
    const uint64_t revision = store->GetStatistics(kMission)->revision;
    ASSERT_TRUE(store->RederiveGlobalLayer(kMission).ok());
    EXPECT_EQ(store->GetStatistics(kMission)->islands, 2u);
    EXPECT_EQ(store->GetStatistics(kMission)->revision, revision + 1);
    ASSERT_TRUE(store->RunFusionUntilIdle(kMission).ok());
    EXPECT_EQ(store->GetStatistics(kMission)->islands, 1u);
  }
  EXPECT_EQ(DumpPlaces(kMission, *other), DumpPlaces(kMission, *undisturbed));
  const std::string derived = DumpGlobal(kMission, *other);
  other.reset();
  EXPECT_EQ(DumpGlobal(kMission, *Open(options)), derived) << "and it lasts";
}

// Counts batches that were acknowledged and are gone after the power was cut, over cuts after each
// acknowledgement.
int CountLost(const std::vector<int>& acknowledged, const std::vector<int>& found) {
  int lost = 0;
  for (size_t i = 0; i < acknowledged.size(); ++i) lost += std::max(0, acknowledged[i] - found[i]);
  return lost;
}

class PowerCutTest : public RocksJournalTest, public ::testing::WithParamInterface<bool> {};

TEST_P(PowerCutTest, KeepsWhatWasAcknowledgedIfAndOnlyIfItSyncs) {
  UnsyncedLossEnv env;
  const RocksJournalOptions options{.directory = Folder("store"),
                                    .min_bytes_between_snapshots = 100000,
                                    .sync = GetParam(),
                                    .env = &env};
  auto store = Open(options);
  const std::vector<MapUpdateBatch> batches = MakeBatches();
  std::vector<int> acknowledged;
  std::vector<int> found;
  for (size_t i = 0; i < batches.size(); ++i) {
    Send(batches, i, i + 1, store.get());
    env.CopyAfterPowerCut(options.directory, Folder("after"));
    const auto after = TryOpen({.directory = Folder("after")});
    for (const uint64_t id : {0xau, 0xbu}) {
      acknowledged.push_back(static_cast<int>(LastBatch(*store, {id})));
      found.push_back(after.ok() ? static_cast<int>(LastBatch(**after, {id})) : 0);
    }
  }
  if (GetParam()) {
    EXPECT_EQ(CountLost(acknowledged, found), 0);
  } else {
    EXPECT_GT(CountLost(acknowledged, found), 0) << "the test can't tell";
  }
}
INSTANTIATE_TEST_SUITE_P(Synced, PowerCutTest, ::testing::Bool(),
                         ::testing::PrintToStringParamName());

// CORBSLAM_TORN_LOGS says how many logs are cut, and in how many a bit is turned.
int LogsWanted() {
  int logs = 30;
  const char* text = std::getenv("CORBSLAM_TORN_LOGS");
  const bool is_number = text == nullptr || absl::SimpleAtoi(text, &logs);
  EXPECT_TRUE(is_number) << text;
  return logs;
}

void TurnABit(const fs::path& path, uint64_t at) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(at));
  const int byte = file.get();
  file.seekp(static_cast<std::streamoff>(at));
  file.put(static_cast<char>(byte ^ 0x10));
}

class DamagedLogTest : public RocksJournalTest {
 protected:
  static constexpr size_t kBatches = 12;

  DamagedLogTest() {
    const std::string original = Folder("original");
    auto store = Open({.directory = original});
    const std::vector<MapUpdateBatch> batches = MakeBatches();
    whole_.emplace_back();
    log_bytes_.push_back(0);
    for (size_t i = 0; i < kBatches; ++i) {
      const bool is_a = batches[i].local_map == LocalMapId{0xa};
      const uint64_t session = OpenSession(is_a ? "a" : "b", store.get());
      EXPECT_TRUE(store->Apply(session, batches[i]).ok());
      log_bytes_.push_back(fs::file_size(LogIn(original)));
      EXPECT_TRUE(store->RunFusionUntilIdle(kMission).ok());
      whole_.push_back(DumpLocal(kMission, *store));
    }
    fs::copy(original, live_, fs::copy_options::recursive);
    // A log that is torn by a crash has lost nothing that was durable; here it has, and the mark
    // would say so.
    fs::remove(MissionFolder(live_) + "/" + kDurableMark);
  }

  // Returns the log that is written to.
  static fs::path LogIn(const std::string& folder) {
    fs::path newest;
    for (const auto& entry : fs::directory_iterator(MissionFolder(folder))) {
      if (entry.path().extension() == ".log") newest = std::max(newest, entry.path());
    }
    return newest;
  }

  // Makes a copy whose log is damaged at a random byte, and returns that byte's index.
  template <typename Damage>
  uint64_t MakeDamaged(Damage damage) {
    fs::remove_all(damaged_);
    fs::copy(live_, damaged_, fs::copy_options::recursive);
    const fs::path log = LogIn(damaged_);
    random_ = random_ * 6364136223846793005U + 1442695040888963407U;
    const uint64_t at = (random_ >> 20) % fs::file_size(log);
    damage(log, at);
    return at;
  }

  // Returns how many batches the damaged store has, each of which it must have to the last bit; -1:
  // it was refused as damaged.
  int CountWholeBatches() {
    const auto store = TryOpen({.directory = damaged_});
    EXPECT_TRUE(store.ok()) << store.status();
    if (!store.ok()) return -1;
    const auto mission = (*store)->GetMission(kMission);
    if (!mission.ok()) return 0;
    if (!mission->damage.empty()) {
      EXPECT_THAT(mission->damage, HasSubstr(MissionFolder(damaged_)));
      return -1;
    }
    const std::string dump = DumpLocal(kMission, **store);
    const auto same = std::ranges::find(whole_, dump);
    EXPECT_NE(same, whole_.end()) << "not what any number of whole batches gives:\n" << dump;
    return static_cast<int>(same - whole_.begin());
  }
  // Returns how many batches are in the log's first `bytes`.
  int CountWritten(uint64_t bytes) const {
    return static_cast<int>(std::ranges::upper_bound(log_bytes_, bytes) - log_bytes_.begin()) - 1;
  }

  const std::string live_ = Folder("live");
  const std::string damaged_ = Folder("damaged");
  // What look-ups say, and the log's length, after each number of batches.
  std::vector<std::string> whole_;
  std::vector<uint64_t> log_bytes_;
  uint64_t random_ = 12345;
};

TEST_F(DamagedLogTest, ACutLogGivesEveryBatchThatIsWholeInIt) {
  const int logs = LogsWanted();
  for (int i = 0; i < logs; ++i) {
    const uint64_t at =
        MakeDamaged([](const fs::path& log, uint64_t end) { fs::resize_file(log, end); });
    EXPECT_EQ(CountWholeBatches(), CountWritten(at)) << "cut at " << at;
  }
  std::printf("%d cut logs opened with every whole batch\n", logs);
}

TEST_F(DamagedLogTest, ATurnedBitIsRefusedOrGivesWholeBatches) {
  const int logs = LogsWanted();
  int refused = 0;
  for (int i = 0; i < logs; ++i) {
    const uint64_t at = MakeDamaged(TurnABit);
    const int found = CountWholeBatches();
    if (found < 0) {
      ++refused;
    } else {
      EXPECT_GE(found, CountWritten(at)) << "turned at " << at;
    }
  }
  EXPECT_GT(refused, logs / 2);
  std::printf("%d logs with a turned bit: %d refused by name, the others opened with all before\n",
              logs, refused);
}

// A keyframe is the one that came first under its id, before a restart and after.
TEST_F(RocksJournalTest, AKeyframeThatComesAgainWithOtherFeaturesChangesNothing) {
  const RocksJournalOptions options{.directory = Folder("store")};
  auto store = Open(options);
  const std::vector<MapUpdateBatch> batches = MakeBatches();
  Send(batches, 0, 4, store.get());
  const std::string local = DumpLocal(kMission, *store);
  MapUpdateBatch again = batches[2];
  again.number = 3;
  again.tracked_frames.clear();
  auto payload = std::make_shared<KeyframePayload>(*again.full_keyframes[0].payload);
  payload->features.keypoints.resize(1);
  payload->features.descriptors.resize(1);
  again.full_keyframes[0].payload = payload;
  const auto acknowledged = store->Apply(OpenSession("a", store.get()), again);
  ASSERT_TRUE(acknowledged.ok()) << acknowledged.status();
  const std::string live = DumpLocal(kMission, *store);
  store.reset();
  store = Open(options);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(DumpLocal(kMission, *store), live);
  // Only the batch's number has changed.
  EXPECT_EQ(live.substr(live.find("000000000000000a:")),
            local.substr(local.find("000000000000000a:")));
}

TEST_F(RocksJournalTest, ADeletedMissionStaysDeleted) {
  const RocksJournalOptions options{.directory = Folder("store")};
  auto store = Open(options);
  Send(MakeBatches(), 0, 6, store.get());
  ASSERT_TRUE(store->DeleteMission(kMission).ok());
  store.reset();
  store = Open(options);
  EXPECT_TRUE(absl::IsNotFound(store->GetMission(kMission).status()));
  // The mission's name is free again.
  Send(MakeBatches(), 0, 2, store.get());
  EXPECT_EQ(store->GetMission(kMission)->keyframes, 2u);
}

TEST_F(RocksJournalTest, AMissionMadeAheadOutlivesAPowerCut) {
  UnsyncedLossEnv env;
  const RocksJournalOptions options{.directory = Folder("store"), .env = &env};
  auto store = Open(options);
  MissionProfile wanted;
  wanted.limits.keyframes = 9;
  ASSERT_TRUE(store->CreateMission("ahead", wanted).ok());
  const MissionProfile made = store->GetMission("ahead")->profile;
  env.CopyAfterPowerCut(options.directory, Folder("after"));
  store = Open({.directory = Folder("after")});
  ASSERT_NE(store, nullptr);
  ASSERT_TRUE(store->GetMission("ahead").ok());
  EXPECT_EQ(store->GetMission("ahead")->profile, made);
  ASSERT_TRUE(store->UpdateMission("ahead", {}, {ProfileField::kLimits}).ok());
  store.reset();
  store = Open({.directory = Folder("after")});
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(store->GetMission("ahead")->profile.limits.keyframes, 0u);
}

}  // namespace
}  // namespace corbslam::map_store
