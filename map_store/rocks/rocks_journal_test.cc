// Tests a store that is killed at any moment, on a disk that keeps only what was synced.
#include "map_store/rocks/rocks_journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rocksdb/db.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/archive/archive.h"
#include "map_store/map_store.h"
#include "map_store/rocks/durable_mark.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"
#include "map_store/testing/unsynced_loss_env.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DeterministicOptions;
using testing::DumpGlobal;
using testing::DumpLocal;
using testing::DumpPlaces;
using ::testing::HasSubstr;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;
using testing::UnsyncedLossEnv;

constexpr char kMission[] = "m";

class RocksJournalTest : public ::testing::Test {
 protected:
  RocksJournalTest() {
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  ~RocksJournalTest() override { fs::remove_all(root_); }

  std::string Folder(const std::string& name) const { return (root_ / name).string(); }

  absl::StatusOr<std::unique_ptr<MapStore>> TryOpen(RocksJournalOptions options) {
    absl::StatusOr<std::unique_ptr<RocksJournal>> journal = RocksJournal::Open(options);
    if (!journal.ok()) return journal.status();
    auto store = std::make_unique<MapStore>(DeterministicOptions(), TheWorld().vocabulary,
                                            *std::move(journal), &worker_);
    const absl::Status recovered = store->Recover();
    if (!recovered.ok()) return recovered;
    return store;
  }
  std::unique_ptr<MapStore> Open(const RocksJournalOptions& options) {
    auto store = TryOpen(options);
    EXPECT_TRUE(store.ok()) << store.status();
    return store.ok() ? *std::move(store) : nullptr;
  }

  // Returns the batches of both robots in turn, as they would come.
  std::vector<MapUpdateBatch> MakeBatches() {
    MapStore scratch(DeterministicOptions(), nullptr, std::make_unique<InMemoryJournal>(), nullptr);
    TestAgent a(scratch, "scratch", "a", map_a_);
    TestAgent b(scratch, "scratch", "b", map_b_);
    std::vector<MapUpdateBatch> batches;
    for (int i = 0; i < 14; ++i) {
      batches.push_back(a.NextBatch(1));
      batches.push_back(b.NextBatch(1));
    }
    return batches;
  }

  static uint64_t OpenSession(const std::string& agent, MapStore* store) {
    SessionRequest request;
    request.mission = kMission;
    request.agent = agent;
    return store->OpenSession(request)->session_id;
  }

  // Sends batches [begin, end) and fuses after each.
  static void Send(const std::vector<MapUpdateBatch>& batches, size_t begin, size_t end,
                   MapStore* store) {
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
  static uint64_t LastBatch(const MapStore& store, LocalMapId id) {
    const auto info = store.GetLocalMap(kMission, id);
    return info.ok() ? info->last_batch : 0;
  }

  const fs::path root_ = fs::path(::testing::TempDir()) / "rocks_journal_test" /
                         ::testing::UnitTest::GetInstance()->current_test_info()->name();
  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 14);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 14);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
};

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
INSTANTIATE_TEST_SUITE_P(Synced, PowerCutTest, ::testing::Bool());

// CORBSLAM_TORN_LOGS says how many logs are cut, and in how many a bit is turned.
int LogsWanted() {
  int logs = 30;
  const char* text = std::getenv("CORBSLAM_TORN_LOGS");
  const bool is_number = text == nullptr || absl::SimpleAtoi(text, &logs);
  EXPECT_TRUE(is_number) << text;
  return logs;
}

// Returns the folder of the mission's own database.
std::string MissionFolder(const std::string& folder) {
  return map_store::JournalFolder(folder).PathOf(kMission);
}

// Returns the log that is written to.
fs::path LogIn(const std::string& folder) {
  fs::path newest;
  for (const auto& entry : fs::directory_iterator(MissionFolder(folder))) {
    if (entry.path().extension() == ".log") newest = std::max(newest, entry.path());
  }
  return newest;
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

TEST_F(RocksJournalTest, AFullDiskIsSaidAndForgottenOnceThereIsRoom) {
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
TEST_F(RocksJournalTest, FindsOutByItselfThatThereIsRoomAgain) {
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

TEST_F(RocksJournalTest, LeavesTheDiskItsReserve) {
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

TEST_F(RocksJournalTest, ARestoreHoldsUpNobodysSync) {
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

TEST_F(RocksJournalTest, TheFormatBeforeBecomesThisOneSoThatOlderProgramsRefuseIt) {
  const RocksJournalOptions options{.directory = Folder("store")};
  auto store = Open(options);
  Send(MakeBatches(), 0, 6, store.get());
  const size_t keyframes = store->GetMission(kMission)->keyframes;
  store.reset();
  rocksdb::DB* raw = nullptr;
  ASSERT_TRUE(rocksdb::DB::Open({}, options.directory, &raw).ok());
  std::unique_ptr<rocksdb::DB> guard(raw);
  ASSERT_TRUE(guard->Put({}, map_store::FormatKey(), std::string("\x0b\0\0\0", 4)).ok());
  guard.reset();
  store = Open(options);
  EXPECT_EQ(store->GetMission(kMission)->keyframes, keyframes);
  store.reset();
  ASSERT_TRUE(rocksdb::DB::OpenForReadOnly({}, options.directory, &raw).ok());
  guard.reset(raw);
  std::string format;
  ASSERT_TRUE(guard->Get({}, map_store::FormatKey(), &format).ok());
  EXPECT_EQ(format, map_store::EncodeFormat());
}

// Makes of a journal what programs of older formats wrote: one database with all missions.
void MakeShared(const std::string& folder, const std::string& format) {
  rocksdb::DB* raw = nullptr;
  ASSERT_TRUE(rocksdb::DB::Open({}, folder, &raw).ok());
  const std::unique_ptr<rocksdb::DB> shared(raw);
  std::string before;
  ASSERT_TRUE(shared->Get({}, map_store::FormatKey(), &before).ok());
  EXPECT_EQ(before, map_store::EncodeFormat());
  ASSERT_TRUE(rocksdb::DB::OpenForReadOnly({}, MissionFolder(folder), &raw).ok());
  const std::unique_ptr<rocksdb::DB> own(raw);
  const std::unique_ptr<rocksdb::Iterator> it(own->NewIterator({}));
  for (it->SeekToFirst(); it->Valid(); it->Next()) {
    ASSERT_TRUE(shared->Put({}, it->key(), it->value()).ok());
  }
  ASSERT_TRUE(shared->Put({}, map_store::FormatKey(), format).ok());
  ASSERT_TRUE(shared->Close().ok());
  fs::remove_all(map_store::JournalFolder(folder).path());
}

// A program before recorded cameras left format 5.
TEST_F(RocksJournalTest, AnOlderFormatIsReadAndBecomesTheNewOne) {
  const RocksJournalOptions options{.directory = Folder("store")};
  auto store = Open(options);
  Send(MakeBatches(), 0, 6, store.get());
  const std::string local = DumpLocal(kMission, *store);
  store.reset();
  MakeShared(options.directory, std::string("\x05\0\0\0", 4));
  store = Open(options);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(store->GetMission(kMission)->keyframes, 6u);
  EXPECT_EQ(DumpLocal(kMission, *store), local);
  // The missions have left the old database.
  EXPECT_LT(map_store::BytesIn(options.directory),
            map_store::BytesIn(MissionFolder(options.directory)) + (64 << 10));
  store.reset();
  MakeShared(options.directory, std::string("\x04\0\0\0", 4));
  EXPECT_EQ(TryOpen(options).status().code(), absl::StatusCode::kFailedPrecondition);
}

// Puts another format's number into a database, and returns the one that was there.
std::string SwapFormat(const std::string& folder, const std::string& format) {
  rocksdb::DB* raw = nullptr;
  EXPECT_TRUE(rocksdb::DB::Open({}, folder, &raw).ok());
  const std::unique_ptr<rocksdb::DB> database(raw);
  std::string before;
  EXPECT_TRUE(database->Get({}, map_store::FormatKey(), &before).ok());
  EXPECT_TRUE(database->Put({}, map_store::FormatKey(), format).ok());
  EXPECT_TRUE(database->Close().ok());
  return before;
}

// A program before profiles left format 11, in the guard and in each mission.
TEST_F(RocksJournalTest, AJournalWithoutProfilesBecomesOneThatOlderProgramsRefuse) {
  const RocksJournalOptions options{.directory = Folder("store")};
  auto store = Open(options);
  Send(MakeBatches(), 0, 6, store.get());
  const std::string local = DumpLocal(kMission, *store);
  store.reset();
  const std::string eleven("\x0b\0\0\0", 4);
  const std::string now = map_store::EncodeFormat();
  EXPECT_EQ(SwapFormat(options.directory, eleven), now);
  EXPECT_EQ(SwapFormat(MissionFolder(options.directory), eleven), now);
  store = Open(options);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(DumpLocal(kMission, *store), local);
  MissionProfile values;
  values.description = "set";
  ASSERT_TRUE(store->UpdateMission(kMission, values, {ProfileField::kDescription}).ok());
  store.reset();
  EXPECT_EQ(SwapFormat(options.directory, now), now);
  EXPECT_EQ(SwapFormat(MissionFolder(options.directory), now), now);
  store = Open(options);
  ASSERT_NE(store, nullptr);
  EXPECT_EQ(store->GetMission(kMission)->profile.description, "set");
  EXPECT_EQ(DumpLocal(kMission, *store), local);
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

TEST_F(RocksJournalTest, AFullDiskMakesNoMission) {
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

TEST_F(RocksJournalTest, ANewerFormatAndASecondProcessAreRefusedByName) {
  const RocksJournalOptions options{.directory = Folder("store")};
  auto first = RocksJournal::Open(options);
  ASSERT_TRUE(first.ok()) << first.status();
  const auto second = RocksJournal::Open(options);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(second.status().message()), HasSubstr(options.directory));
  EXPECT_THAT(std::string(second.status().message()), HasSubstr("this process itself has it"));

  first->reset();
  rocksdb::DB* raw = nullptr;
  ASSERT_TRUE(rocksdb::DB::Open({}, options.directory, &raw).ok());
  const std::unique_ptr<rocksdb::DB> closing(raw);
  map_store::ArchiveWriter next;
  next(map_store::kJournalFormat + 1);
  ASSERT_TRUE(raw->Put({}, map_store::FormatKey(), next.Take()).ok());
  ASSERT_TRUE(raw->Close().ok());
  const auto newer = RocksJournal::Open(options);
  EXPECT_EQ(newer.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(newer.status().message()),
              HasSubstr(absl::StrCat("has format ", map_store::kJournalFormat + 1)));

  const auto nowhere = RocksJournal::Open({.directory = "/proc/version/journal"});
  EXPECT_EQ(nowhere.status().code(), absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace corbslam::map_store
