// Tests what can be had of damaged missions, and that damage is found while a store runs.
#include "map_store/store/journal_repair.h"

#include <glog/logging.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "map_store/archive/mission_archive.h"
#include "map_store/rocks/journal_scrubber.h"
#include "map_store/testing/journal_room.h"
#include "map_store/testing/store_dump.h"

namespace corbslam::map_store {
namespace {

namespace fs = std::filesystem;
using testing::DumpLocal;
using ::testing::HasSubstr;

class JournalRepairTest : public testing::JournalRoom {
 protected:
  JournalRepairTest() {
    // Opened twice, it has tables, files of features and a log.
    Open();
    Stream("m", 10);
    Open();
    before_ = DumpLocal("m", *store_);
    Stream("m", 4);
    whole_ = DumpLocal("m", *store_);
    Close();
  }

  std::string File() const { return Folder("m.backup"); }
  absl::StatusOr<RepairReport> Repair() {
    const std::map<std::string, uint64_t> files = Sizes();
    absl::StatusOr<RepairReport> report = map_store::RepairMission(Data(), "m", File());
    EXPECT_EQ(Sizes(), files) << "nothing in the folder changes";
    EXPECT_FALSE(fs::exists(File() + ".scratch"));
    return report;
  }
  // Restores the file into another store, and returns what look-ups say.
  std::string Restored() {
    std::ifstream file(File(), std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    MissionRestorer restorer(uint64_t{1} << 40);
    EXPECT_TRUE(restorer.Add(bytes).ok());
    auto state = restorer.Finish();
    EXPECT_TRUE(state.ok()) << state.status();
    MapStore other(testing::DeterministicOptions(), nullptr, std::make_unique<InMemoryJournal>(),
                   nullptr);
    const absl::Status restored = other.RestoreMission("m", *std::move(state));
    EXPECT_TRUE(restored.ok()) << restored;
    return DumpLocal("m", other);
  }
  std::map<std::string, uint64_t> Sizes() const {
    std::map<std::string, uint64_t> sizes;
    for (const auto& entry : fs::recursive_directory_iterator(Data())) {
      if (entry.is_regular_file()) sizes[entry.path().string()] = entry.file_size();
    }
    return sizes;
  }

  std::string before_;
  std::string whole_;
};

TEST_F(JournalRepairTest, OfAWholeMissionNothingIsLost) {
  const auto report = Repair();
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_TRUE(report->salvage.ended.ok()) << report->salvage.ended;
  EXPECT_EQ(report->left_out, 0u);
  EXPECT_EQ(report->keyframes, 14u);
  EXPECT_EQ(Restored(), whole_);
  EXPECT_TRUE(absl::IsAlreadyExists(Repair().status()));
}

TEST_F(JournalRepairTest, KeyframesWithoutFeaturesAreLeftOutAndNamed) {
  const auto features = Files("m", ".blob");
  ASSERT_FALSE(features.empty());
  // Features come first in it: their keys are the least.
  Spoil(features.front(), 64, 0.1);
  const auto report = Repair();
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_GT(report->left_out, 0u);
  EXPECT_LT(report->left_out, 14u);
  EXPECT_EQ(report->left_out, report->salvage.without_features.size());
  EXPECT_EQ(report->keyframes + report->left_out, 14u);
  EXPECT_TRUE(report->salvage.ended.ok()) << report->salvage.ended;
  EXPECT_NE(Restored(), whole_);
}

TEST_F(JournalRepairTest, ADamagedLogGivesWhatComesBefore) {
  for (const fs::path& log : Files("m", ".log")) Spoil(log);
  const auto report = Repair();
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_GE(report->keyframes, 10u);
  EXPECT_LT(report->keyframes, 14u);
  EXPECT_GT(report->salvage.durable, report->salvage.last) << "it says how much is lost";
  Restored();
}

TEST_F(JournalRepairTest, WithoutItsListOfFilesItIsWhatTheFilesHoldOrRefused) {
  fs::remove(MissionFolder("m") / "CURRENT");
  const auto report = Repair();
  if (!report.ok()) {
    EXPECT_TRUE(absl::IsDataLoss(report.status())) << report.status();
    EXPECT_FALSE(fs::exists(File()));
    return;
  }
  EXPECT_FALSE(report->salvage.not_opened.ok());
  EXPECT_EQ(Restored(), before_);
}

TEST_F(JournalRepairTest, RefusesWhatIsNotItsBusiness) {
  EXPECT_TRUE(absl::IsNotFound(map_store::RepairMission(Data(), "nobody", File()).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(
      map_store::RepairMission(Data(), "m", Data() + "/m.backup").status()));
  EXPECT_TRUE(absl::IsFailedPrecondition(
      map_store::RepairMission(Folder("nothing"), "m", File()).status()));
  Open();
  EXPECT_TRUE(absl::IsFailedPrecondition(map_store::RepairMission(Data(), "m", File()).status()));
}

TEST_F(JournalRepairTest, AScrubFindsDamageWhileTheStoreRuns) {
  Open();
  journal_->ScrubNow();
  EXPECT_EQ(journal_->scrub_counts().rounds, 1u);
  EXPECT_GT(journal_->scrub_counts().bytes, 10000u);
  EXPECT_TRUE(store_->ListDamaged().empty());
  Stream("other", 2);
  for (const fs::path& features : Files("m", ".blob")) Spoil(features, 4096);
  journal_->ScrubNow();
  const auto damaged = store_->ListDamaged();
  ASSERT_EQ(damaged.size(), 1u);
  EXPECT_EQ(damaged.begin()->first, "m");
  EXPECT_EQ(journal_->scrub_counts().damaged, 1u);
  journal_->ScrubNow();
  EXPECT_EQ(journal_->scrub_counts().damaged, 1u) << "it is said once";
  EXPECT_EQ(journal_->scrub_counts().rounds, 3u);
}

TEST_F(JournalRepairTest, AScrubReadsTheLogOfAMissionInUse) {
  Open();
  Stream("m", 2);
  Stream("other", 2);
  journal_->ScrubNow();
  EXPECT_TRUE(store_->ListDamaged().empty());
  const fs::path log = Files("m", ".log").back();
  ASSERT_GT(fs::file_size(log), 1000u);
  Spoil(log, 4);
  journal_->ScrubNow();
  const auto damaged = store_->ListDamaged();
  ASSERT_EQ(damaged.size(), 1u);
  EXPECT_THAT(damaged.begin()->second, HasSubstr(log.string()));
}

// Whatever file of a mission that sleeps is damaged, its name is said, and the mission is not woken
// for that.
TEST_F(JournalRepairTest, AScrubReadsMissionsThatAreAsleep) {
  for (const std::string ending : {".sst", ".blob", ".log", "", "MANIFEST"}) {
    SCOPED_TRACE(ending);
    Open();
    Stream("sleeper", 6);
    ASSERT_TRUE(store_->SleepMission("sleeper").ok());
    journal_->ScrubNow();
    EXPECT_TRUE(store_->ListDamaged().empty());
    fs::path file = MissionFolder("sleeper") / "CURRENT";
    if (ending == "MANIFEST") {
      for (const fs::path& other : Files("sleeper", "")) {
        if (other.filename().string().starts_with(ending)) file = other;
      }
    } else if (!ending.empty()) {
      ASSERT_FALSE(Files("sleeper", ending).empty());
      file = Files("sleeper", ending).front();
    }
    if (ending == ".log") {
      fs::remove(file);
    } else {
      Spoil(file, 16);
    }
    journal_->ScrubNow();
    EXPECT_EQ(journal_->scrub_counts().damaged, 1u);
    const auto damaged = store_->ListDamaged();
    ASSERT_EQ(damaged.size(), 1u);
    EXPECT_EQ(damaged.begin()->first, "sleeper");
    EXPECT_THAT(
        damaged.begin()->second,
        HasSubstr(ending == ".log" || ending == ".blob" ? "sleeper" : file.filename().string()));
    EXPECT_TRUE(store_->GetMission("sleeper")->asleep);
    EXPECT_TRUE(absl::IsDataLoss(store_->GetStatistics("sleeper").status())) << "waking finds it";
    ASSERT_TRUE(store_->DeleteMission("sleeper").ok());
    EXPECT_TRUE(store_->ListDamaged().empty());
  }
}

// Keeps what RocksDB says in the log: errors and warnings.
class Complaints : public google::LogSink {
 public:
  Complaints() { google::AddLogSink(this); }
  ~Complaints() override { google::RemoveLogSink(this); }
  void send(google::LogSeverity, const char*, const char*, int, const google::LogMessageTime&,
            const char* message, size_t length) override {
    const std::string text(message, length);
    if (text.starts_with("rocksdb")) said.push_back(text);
  }
  std::vector<std::string> said;
};

TEST_F(JournalRepairTest, AMissionIsMadeWithoutComplaints) {
  Open();
  const Complaints complaints;
  Stream("new", 2);
  EXPECT_THAT(complaints.said, ::testing::IsEmpty());
}

TEST_F(JournalRepairTest, AScrubMissesAFileThatIsGone) {
  Open();
  const auto features = Files("m", ".blob");
  ASSERT_FALSE(features.empty());
  fs::remove(features.front());
  journal_->ScrubNow();
  const auto damaged = store_->ListDamaged();
  ASSERT_EQ(damaged.size(), 1u);
  EXPECT_THAT(damaged.at("m"), HasSubstr(features.front().filename().string()));
}

}  // namespace
}  // namespace corbslam::map_store
