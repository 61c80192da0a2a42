// A journal that only reads: what all such have in common.
#ifndef CORBSLAM_MAP_STORE_ROCKS_READ_ONLY_JOURNAL_H_
#define CORBSLAM_MAP_STORE_ROCKS_READ_ONLY_JOURNAL_H_

#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "map_store/records/journal.h"

namespace corbslam::map_store {

// Has one mission, and refuses all that would write with FAILED_PRECONDITION.
class ReadOnlyJournal : public Journal {
 public:
  explicit ReadOnlyJournal(std::string mission) : mission_(std::move(mission)) {}

  void Prepare(BatchRecord&) const override {}
  void Prepare(AdjustRecord&) const override {}
  absl::StatusOr<Position> Append(absl::string_view, const JournalRecord&) override {
    return OnlyRead();
  }
  absl::Status Sync(absl::string_view, Position) override { return OnlyRead(); }
  bool WantsSnapshot(absl::string_view) const override { return false; }
  absl::Status WriteSnapshot(absl::string_view, const JournalSnapshot&) override {
    return OnlyRead();
  }
  absl::Status CreateMission(absl::string_view, const MissionState&) override { return OnlyRead(); }
  absl::StatusOr<std::vector<std::string>> ListMissions() const override {
    return std::vector<std::string>{mission_};
  }
  absl::Status DeleteMission(absl::string_view) override { return OnlyRead(); }
  absl::Status CheckWritable() override { return OnlyRead(); }

 protected:
  const std::string& mission() const { return mission_; }

 private:
  absl::Status OnlyRead() const {
    return absl::FailedPreconditionError(
        absl::StrCat("these files of mission ", mission_, " are only read"));
  }

  const std::string mission_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_READ_ONLY_JOURNAL_H_
