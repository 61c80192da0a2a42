#include "services/observe/observed_journal.h"

#include <string>
#include <utility>

#include "absl/time/clock.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::Journal;
using map_store::JournalSnapshot;

namespace {

class ObservedJournal : public Journal {
 public:
  ObservedJournal(std::unique_ptr<Journal> journal, std::vector<JournalObserver*> observers)
      : journal_(std::move(journal)), observers_(std::move(observers)) {}

  void Prepare(map_store::BatchRecord& record) const override { journal_->Prepare(record); }
  void Prepare(map_store::AdjustRecord& record) const override { journal_->Prepare(record); }

  absl::StatusOr<Position> Append(absl::string_view mission,
                                  const map_store::JournalRecord& record) override {
    const absl::Time start = absl::Now();
    absl::StatusOr<Position> position = journal_->Append(mission, record);
    for (JournalObserver* observer : observers_) {
      observer->OnAppended(mission, record, absl::Now() - start, position.status());
    }
    return position;
  }

  absl::Status Sync(absl::string_view mission, Position position) override {
    const absl::Time start = absl::Now();
    const absl::Status status = journal_->Sync(mission, position);
    for (JournalObserver* observer : observers_) observer->OnSynced(absl::Now() - start, status);
    return status;
  }

  absl::Status WriteSnapshot(absl::string_view mission, const JournalSnapshot& snapshot) override {
    const absl::Time start = absl::Now();
    const absl::Status status = journal_->WriteSnapshot(mission, snapshot);
    for (JournalObserver* observer : observers_) observer->OnSnapshot(absl::Now() - start, status);
    return status;
  }

  absl::Status CheckWritable() override {
    const absl::Status writable = journal_->CheckWritable();
    for (JournalObserver* observer : observers_) observer->OnChecked(writable);
    return writable;
  }

  bool WantsSnapshot(absl::string_view mission) const override {
    return journal_->WantsSnapshot(mission);
  }
  absl::Status CreateMission(absl::string_view mission,
                             const map_store::MissionState& state) override {
    return journal_->CreateMission(mission, state);
  }
  absl::StatusOr<std::vector<std::string>> ListMissions() const override {
    return journal_->ListMissions();
  }
  bool KeepsRecords() const override { return journal_->KeepsRecords(); }
  absl::StatusOr<Position> Recover(absl::string_view mission, const Replay& replay) const override {
    return journal_->Recover(mission, replay);
  }
  absl::Status NoteInList(map_store::MissionList list,
                          const map_store::MissionIdentity& mission) override {
    return journal_->NoteInList(list, mission);
  }
  std::vector<map_store::MissionIdentity> ReadList(map_store::MissionList list) const override {
    return journal_->ReadList(list);
  }
  absl::Status DeleteMission(absl::string_view mission) override {
    return journal_->DeleteMission(mission);
  }
  void TidyUp(absl::string_view mission) override { journal_->TidyUp(mission); }
  absl::Status PutAside(absl::string_view mission, absl::string_view summary) override {
    return journal_->PutAside(mission, summary);
  }
  absl::StatusOr<std::string> ReadSummary(absl::string_view mission) const override {
    return journal_->ReadSummary(mission);
  }
  absl::Status PutPicture(absl::string_view mission, const KeyframePicture& picture,
                          uint64_t max_bytes) override {
    return journal_->PutPicture(mission, picture, max_bytes);
  }
  absl::StatusOr<KeyframePicture> ReadPicture(absl::string_view mission,
                                              KeyframeId keyframe) const override {
    return journal_->ReadPicture(mission, keyframe);
  }
  absl::Status ForEachPicture(
      absl::string_view mission,
      const std::function<absl::Status(const KeyframePicture&)>& visit) const override {
    return journal_->ForEachPicture(mission, visit);
  }
  absl::Status Damage(absl::string_view mission) const override {
    return journal_->Damage(mission);
  }
  uint64_t DiskBytes(absl::string_view mission) const override {
    return journal_->DiskBytes(mission);
  }
  map_store::MissionLeases* leases() override { return journal_->leases(); }
  absl::StatusOr<std::vector<map_store::MissionIdentity>> ReadListOf(
      map_store::MissionList list, absl::string_view mission) const override {
    return journal_->ReadListOf(list, mission);
  }

 private:
  const std::unique_ptr<Journal> journal_;
  const std::vector<JournalObserver*> observers_;
};

}  // namespace

std::unique_ptr<Journal> MakeObservedJournal(std::unique_ptr<Journal> journal,
                                             std::vector<JournalObserver*> observers) {
  return std::make_unique<ObservedJournal>(std::move(journal), std::move(observers));
}

}  // namespace corbslam::services
