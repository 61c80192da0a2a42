// Tests that a mission taken to a file is made again from it, in the same store or in another.
#include "map_store/archive/mission_archive.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rocksdb/db.h>

#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/archive/state_archive.h"
#include "map_store/rocks/journal_folder.h"
#include "map_store/rocks/journal_keys.h"
#include "map_store/rocks/mission_header.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "map_store/testing/shared_world.h"
#include "map_store/testing/store_dump.h"
#include "map_store/testing/test_agent.h"
#include "map_store/testing/truthful_worker.h"
#include "map_store/testing/unsynced_loss_env.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using testing::DeterministicOptions;
using testing::DumpGlobal;
using testing::DumpLocal;
using ::testing::HasSubstr;
using testing::MakeRingMap;
using testing::SyntheticMap;
using testing::TestAgent;
using testing::TheWorld;
using testing::TruthfulWorker;
using testing::UnsyncedLossEnv;

constexpr uint64_t kNoLimit = std::numeric_limits<uint64_t>::max();

absl::StatusOr<MissionState> Read(const std::string& file, size_t piece_bytes = 100000,
                                  uint64_t max_bytes = kNoLimit) {
  MissionRestorer restorer(max_bytes);
  for (size_t at = 0; at < file.size(); at += piece_bytes) {
    const absl::Status status = restorer.Add(std::string_view(file).substr(at, piece_bytes));
    if (!status.ok()) return status;
  }
  return restorer.Finish();
}

class MissionArchiveTest : public ::testing::Test {
 protected:
  MissionArchiveTest() : store_(MakeStore(std::make_unique<InMemoryJournal>())) {
    fs::remove_all(root_);
    fs::create_directories(root_);
    alpha_ = std::make_unique<TestAgent>(*store_, "m", "alpha", map_a_);
    bravo_ = std::make_unique<TestAgent>(*store_, "m", "bravo", map_b_);
    for (int i = 0; i < 12; ++i) {
      EXPECT_TRUE(alpha_->Stream(1).ok());
      EXPECT_TRUE(bravo_->Stream(1).ok());
    }
    EXPECT_TRUE(store_->RunFusionUntilIdle("m").ok());
    EXPECT_EQ(store_->GetStatistics("m")->islands, 1u);
  }
  ~MissionArchiveTest() override { fs::remove_all(root_); }

  std::unique_ptr<MapStore> MakeStore(std::unique_ptr<Journal> journal) {
    return std::make_unique<MapStore>(DeterministicOptions(), TheWorld().vocabulary,
                                      std::move(journal), &worker_);
  }
  std::string Folder(const std::string& name) const { return (root_ / name).string(); }
  std::unique_ptr<MapStore> OpenStore(const RocksJournalOptions& options) {
    auto journal = RocksJournal::Open(options);
    EXPECT_TRUE(journal.ok()) << journal.status();
    auto store = MakeStore(*std::move(journal));
    EXPECT_TRUE(store->Recover().ok());
    return store;
  }

  std::string BackUp(size_t piece_bytes = 100000) const {
    MissionBackup backup = *store_->BackUpMission("m");
    std::string file;
    for (std::string piece = backup.Next(piece_bytes); !piece.empty();
         piece = backup.Next(piece_bytes)) {
      file += piece;
    }
    return file;
  }

  const fs::path root_ = fs::path(::testing::TempDir()) / "mission_archive_test" /
                         ::testing::UnitTest::GetInstance()->current_test_info()->name();
  SyntheticMap map_a_ = MakeRingMap(0xa, 0, 16);
  SyntheticMap map_b_ = MakeRingMap(0xb, 32, 16);
  TruthfulWorker worker_{{&map_a_, &map_b_}};
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<TestAgent> alpha_;
  std::unique_ptr<TestAgent> bravo_;
};

TEST_F(MissionArchiveTest, ARestoredMissionIsWhatItWas) {
  const std::string file = BackUp();
  EXPECT_EQ(BackUp(7), file) << "pieces are only cuts";
  auto state = Read(file, 333);
  ASSERT_TRUE(state.ok()) << state.status();
  ASSERT_TRUE(store_->RestoreMission("copy", *std::move(state)).ok());
  EXPECT_EQ(DumpLocal("copy", *store_), DumpLocal("m", *store_));
  EXPECT_EQ(DumpGlobal("copy", *store_), DumpGlobal("m", *store_));
}

TEST_F(MissionArchiveTest, ABackupIsOfOneMoment) {
  const std::string local = DumpLocal("m", *store_);
  MissionBackup backup = *store_->BackUpMission("m");
  std::string file = backup.Next(1);
  ASSERT_TRUE(alpha_->Stream(3).ok());
  ASSERT_TRUE(store_->DeleteMission("m").ok());
  for (std::string piece = backup.Next(50000); !piece.empty(); piece = backup.Next(50000)) {
    file += piece;
  }
  auto state = Read(file);
  ASSERT_TRUE(state.ok()) << state.status();
  ASSERT_TRUE(store_->RestoreMission("m", *std::move(state)).ok());
  EXPECT_EQ(DumpLocal("m", *store_), local);
}

TEST_F(MissionArchiveTest, AgentsGoOnInTheRestoredMissionOfAnotherStoreAndItLasts) {
  const RocksJournalOptions options{.directory = Folder("store")};
  auto other = OpenStore(options);
  ASSERT_TRUE(other->RestoreMission("m", *Read(BackUp())).ok());
  SessionRequest request;
  request.mission = "m";
  request.agent = "alpha";
  request.local_maps = {LocalMapId{0xa}};
  const auto session = other->OpenSession(request);
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->grant.acknowledged.at(0).number, 12u);
  const MapUpdateBatch next = alpha_->NextBatch(1);
  ASSERT_TRUE(other->Apply(session->session_id, next).ok());
  ASSERT_TRUE(other->RunFusionUntilIdle("m").ok());
  EXPECT_EQ(other->GetMission("m")->keyframes, 25u);

  const std::string local = DumpLocal("m", *other);
  const std::string global = DumpGlobal("m", *other);
  other.reset();
  other = OpenStore(options);
  EXPECT_EQ(DumpLocal("m", *other), local);
  EXPECT_EQ(DumpGlobal("m", *other), global);
}

TEST_F(MissionArchiveTest, AMissionThatIsThereIsNotOverwritten) {
  const std::string local = DumpLocal("m", *store_);
  EXPECT_TRUE(absl::IsAlreadyExists(store_->RestoreMission("m", *Read(BackUp()))));
  EXPECT_EQ(DumpLocal("m", *store_), local);
  EXPECT_TRUE(absl::IsInvalidArgument(store_->RestoreMission("a/b", *Read(BackUp()))));
  EXPECT_TRUE(absl::IsNotFound(store_->BackUpMission("nowhere").status()));
}

TEST_F(MissionArchiveTest, RecordedCamerasGoAlongWhateverTheirLens) {
  const std::vector<LensModel> lenses = {RadialTangential{-0.1, 0.01, 0, 0, 0.001},
                                         RadialTangential{-0.1, 0.01, 0, 0, 0.001, 0.3, 0.2, 0.1},
                                         Equidistant{0.1, 0.2, 0.3, 0.4}, DoubleSphere{-0.2, 0.59},
                                         UnifiedSphere{1.2, {-0.1, 0.02, 0.03, 0.04, 0.05}}};
  for (const LensModel& lens : lenses) {
    auto state = *Read(BackUp());
    RecordedCamera recorded;
    recorded.lens = {400, 401, 320, 240, lens};
    recorded.body_from_recorded = Rigid3d{Eigen::Quaterniond::Identity(), {1, 2, 3}};
    state.local_maps.begin()->second.recorded_cameras = {recorded};
    const std::string copy = absl::StrCat("copy_", &lens - lenses.data());
    ASSERT_TRUE(store_->RestoreMission(copy, std::move(state)).ok());
    MissionBackup backup = *store_->BackUpMission(copy);
    std::string file;
    for (std::string piece = backup.Next(1 << 20); !piece.empty(); piece = backup.Next(1 << 20)) {
      file += piece;
    }
    const auto read = Read(file);
    ASSERT_TRUE(read.ok()) << read.status();
    EXPECT_EQ(read->local_maps.begin()->second.Recorded(), recorded) << NameOf(lens);
    EXPECT_FALSE(read->local_maps.rbegin()->second.Recorded().has_value());
  }
}

TEST_F(MissionArchiveTest, AProfileGoesAlong) {
  MissionProfile values;
  values.description = "the old mine";
  values.labels = {{"site", "3"}, {"none", ""}};
  values.limits = {1, 2, 3, 4000};
  values.agent_limits["alpha"].keyframes = 5;
  values.retention_s = 6;
  values.origin = GeoOrigin{7, 8, 9, 10};
  using Field = ProfileField;
  ASSERT_TRUE(store_
                  ->UpdateMission("m", values,
                                  {Field::kDescription, Field::kLabels, Field::kLimits,
                                   Field::kAgentLimits, Field::kRetention, Field::kOrigin})
                  .ok());
  const SignedSettings settings{3, "signed", std::string(64, 's')};
  ASSERT_TRUE(store_->SetRobotSettings("m", "alpha", settings).ok());
  values.revision = 1;
  values.robot_settings["alpha"] = settings;
  const auto read = Read(BackUp());
  ASSERT_TRUE(read.ok()) << read.status();
  values.created_ns = read->profile.created_ns;
  values.last_used_ns = read->profile.last_used_ns;
  EXPECT_EQ(read->profile, values);
  EXPECT_GT(values.created_ns, 0);
  EXPECT_GE(values.last_used_ns, values.created_ns);
}

TEST_F(MissionArchiveTest, DamageIsFoundWhereverItIs) {
  const std::string file = BackUp();
  const size_t step = file.size() / 400 + 1;
  for (size_t at = 0; at < file.size(); at += step) {
    std::string damaged = file;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x20);
    EXPECT_FALSE(Read(damaged).ok()) << at;
    EXPECT_TRUE(absl::IsDataLoss(Read(file.substr(0, at)).status())) << at;
  }
  EXPECT_TRUE(absl::IsDataLoss(Read(file + "x").status()));
  EXPECT_TRUE(absl::IsFailedPrecondition(Read("a picture of a cat").status()));
  std::string newer = file;
  newer[8] = static_cast<char>(file[8] + 1);
  EXPECT_THAT(std::string(Read(newer).status().message()),
              HasSubstr(absl::StrCat("has format ", file[8] + 1)));
  EXPECT_TRUE(absl::IsResourceExhausted(Read(file, 1000, file.size() - 1).status()));
}

TEST_F(MissionArchiveTest, AnOlderFormatIsRefusedWithWhatReadsIt) {
  std::string older = BackUp();
  older[8] = 11;
  const absl::Status refused = Read(older).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << refused;
  EXPECT_THAT(std::string(refused.message()),
              AllOf(HasSubstr("has format 11, this program reads 12 to 13"),
                    HasSubstr("commit f5f37d9e"), HasSubstr("corbslam mission backup")));
  std::string state = map_store::EncodeState(*Read(BackUp()));
  state[0] = 9;
  const absl::Status unread = map_store::DecodeState(state, nullptr).status();
  EXPECT_TRUE(absl::IsDataLoss(unread)) << unread;
  EXPECT_THAT(
      std::string(unread.message()),
      AllOf(HasSubstr("has format 9, this program reads 10 to 11"), HasSubstr("commit f5f37d9e")));
}

TEST_F(MissionArchiveTest, WhatAgentsMayNotSendMayNotBeRestored) {
  auto state = *Read(BackUp());
  state.global.keyframes.begin()->second.camera_from_island.translation.x() =
      std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(absl::IsInvalidArgument(store_->RestoreMission("copy", std::move(state))));
  MapStoreOptions small = DeterministicOptions();
  small.max_local_maps_per_mission = 1;
  MapStore other(small, TheWorld().vocabulary, std::make_unique<InMemoryJournal>(), nullptr);
  EXPECT_TRUE(absl::IsResourceExhausted(other.RestoreMission("copy", *Read(BackUp()))));
  EXPECT_TRUE(absl::IsNotFound(other.GetMission("copy").status()));
}

// The process is killed, as it were, in the middle of a restore.
TEST_F(MissionArchiveTest, AHalfRestoredMissionIsGoneAtTheNextStart) {
  const RocksJournalOptions options{.directory = Folder("store")};
  OpenStore(options).reset();
  {
    rocksdb::DB* raw = nullptr;
    rocksdb::Options make;
    make.create_if_missing = true;
    const std::string folder = map_store::JournalFolder(options.directory).PathOf("m");
    ASSERT_TRUE(rocksdb::DB::Open(make, folder, &raw).ok());
    const std::unique_ptr<rocksdb::DB> journal(raw);
    ASSERT_TRUE(raw->Put({}, map_store::FormatKey(), EncodeFormat()).ok());
    const std::string not_whole(8, '\xff');
    ASSERT_TRUE(raw->Put({}, map_store::MissionKey("m"), not_whole + std::string(8, '\0')).ok());
    ASSERT_TRUE(raw->Put({}, map_store::FeaturesKey("m", {LocalMapId{0xa}, 3}), "half").ok());
    ASSERT_TRUE(raw->Put({}, map_store::SnapshotKey("m", 1, 0), "half").ok());
  }
  auto store = OpenStore(options);
  EXPECT_TRUE(absl::IsNotFound(store->GetMission("m").status()));
  ASSERT_TRUE(store->RestoreMission("m", *Read(BackUp())).ok());
  EXPECT_EQ(DumpLocal("m", *store), DumpLocal("m", *store_));
  store.reset();
  store = OpenStore(options);
  EXPECT_EQ(DumpLocal("m", *store), DumpLocal("m", *store_));
}

TEST_F(MissionArchiveTest, AFullDiskLeavesNothingBehind) {
  UnsyncedLossEnv env;
  const RocksJournalOptions options{.directory = Folder("store"), .env = &env};
  auto store = OpenStore(options);
  env.SetFull(true);
  const absl::Status full = store->RestoreMission("m", *Read(BackUp()));
  EXPECT_TRUE(absl::IsResourceExhausted(full)) << full;
  EXPECT_TRUE(absl::IsNotFound(store->GetMission("m").status()));
  env.SetFull(false);
  absl::Status again = store->RestoreMission("m", *Read(BackUp()));
  for (int i = 0; i < 600 && absl::IsResourceExhausted(again); ++i) {
    absl::SleepFor(absl::Milliseconds(100));
    again = store->RestoreMission("m", *Read(BackUp()));
  }
  EXPECT_TRUE(again.ok()) << again;
  store.reset();
  store = OpenStore(options);
  EXPECT_EQ(DumpLocal("m", *store), DumpLocal("m", *store_));
}

}  // namespace
}  // namespace corbslam::map_store
