#include "services/observe/observed_journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/testing/small_mission.h"

namespace corbslam::services {

using map_store::InMemoryJournal;

namespace {

using ::testing::ElementsAre;

// A journal in memory that fails on demand.
class FailingJournal : public InMemoryJournal {
 public:
  explicit FailingJournal(const absl::Status* failure) : failure_(*failure) {}

  absl::StatusOr<Position> Append(absl::string_view mission,
                                  const map_store::JournalRecord& record) override {
    if (!failure_.ok()) return failure_;
    return InMemoryJournal::Append(mission, record);
  }
  absl::Status Sync(absl::string_view, Position) override { return failure_; }
  absl::Status CheckWritable() override { return failure_; }

 private:
  const absl::Status& failure_;
};

// Prepares records, so that it is seen.
class PreparingJournal : public InMemoryJournal {
 public:
  void Prepare(map_store::BatchRecord& record) const override {
    record.bytes = std::make_shared<const map_store::BatchBytes>();
  }
  void Prepare(map_store::AdjustRecord& record) const override {
    record.plan_bytes = std::make_shared<const map_store::PlanBytes>();
  }
};

class Notes : public JournalObserver {
 public:
  void OnAppended(absl::string_view mission, const map_store::JournalRecord& record, absl::Duration,
                  const absl::Status& status) override {
    notes.push_back(absl::StrCat("append ", mission, " ", record.index(), " ", Code(status)));
  }
  void OnSynced(absl::Duration, const absl::Status& status) override {
    notes.push_back("sync " + Code(status));
  }
  void OnSnapshot(absl::Duration, const absl::Status& status) override {
    notes.push_back("snapshot " + Code(status));
  }
  void OnChecked(const absl::Status& writable) override {
    notes.push_back("check " + Code(writable));
  }

  std::vector<std::string> notes;

 private:
  static std::string Code(const absl::Status& status) {
    return absl::StatusCodeToString(status.code());
  }
};

TEST(ObservedJournalTest, RecordsArePreparedByTheJournalItself) {
  const auto journal = MakeObservedJournal(std::make_unique<PreparingJournal>(), {});
  map_store::BatchRecord batch;
  map_store::AdjustRecord adjustment;
  journal->Prepare(batch);
  journal->Prepare(adjustment);
  EXPECT_NE(batch.bytes, nullptr);
  EXPECT_NE(adjustment.plan_bytes, nullptr);
}

TEST(ObservedJournalTest, ObserversHearWhatHappenedAndHowItEnded) {
  absl::Status failure;
  auto in_memory = std::make_unique<FailingJournal>(&failure);
  const InMemoryJournal& inner = *in_memory;
  Notes notes;
  const auto journal = MakeObservedJournal(std::move(in_memory), {&notes});
  const map_store::JournalRecord record = testing::MakeSmallMission().front();
  EXPECT_TRUE(journal->Append("lab", record).ok());
  EXPECT_TRUE(journal->Sync("m", 1).ok());
  EXPECT_TRUE(journal->CheckWritable().ok());
  EXPECT_TRUE(journal->WriteSnapshot("lab", {}).ok());
  EXPECT_TRUE(journal->DeleteMission("lab").ok());
  EXPECT_EQ(inner.records(), 1u);
  failure = absl::ResourceExhaustedError("full");
  EXPECT_EQ(journal->Append("lab", record).status(), failure);
  EXPECT_EQ(journal->Sync("m", 1), failure);
  EXPECT_EQ(journal->CheckWritable(), failure);
  EXPECT_THAT(notes.notes, ElementsAre("append lab 0 OK", "sync OK", "check OK", "snapshot OK",
                                       "append lab 0 RESOURCE_EXHAUSTED", "sync RESOURCE_EXHAUSTED",
                                       "check RESOURCE_EXHAUSTED"));
}

}  // namespace
}  // namespace corbslam::services
