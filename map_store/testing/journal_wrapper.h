// A journal that passes all on to another one, for tests that change or count some of it.
#ifndef CORBSLAM_MAP_STORE_TESTING_JOURNAL_WRAPPER_H_
#define CORBSLAM_MAP_STORE_TESTING_JOURNAL_WRAPPER_H_

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "map_store/records/journal.h"

namespace corbslam::testing {

class JournalWrapper : public map_store::Journal {
 public:
  explicit JournalWrapper(std::unique_ptr<map_store::Journal> journal)
      : journal_(std::move(journal)) {}

  void Prepare(map_store::BatchRecord& record) const override { journal_->Prepare(record); }
  void Prepare(map_store::AdjustRecord& record) const override { journal_->Prepare(record); }
  absl::StatusOr<Position> Append(absl::string_view mission,
                                  const map_store::JournalRecord& record) override {
    return journal_->Append(mission, record);
  }
  absl::Status Sync(absl::string_view mission, Position position) override {
    return journal_->Sync(mission, position);
  }
  bool WantsSnapshot(absl::string_view mission) const override {
    return journal_->WantsSnapshot(mission);
  }
  absl::Status WriteSnapshot(absl::string_view mission,
                             const map_store::JournalSnapshot& snapshot) override {
    return journal_->WriteSnapshot(mission, snapshot);
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
  absl::Status CheckWritable() override { return journal_->CheckWritable(); }
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
  const std::unique_ptr<map_store::Journal> journal_;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_JOURNAL_WRAPPER_H_
