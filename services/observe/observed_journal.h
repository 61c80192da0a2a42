// Makes a journal that tells others what passes through it. Whatever changes a mission passes
// through it, so that metrics need no hooks in the map store itself.
#ifndef CORBSLAM_SERVICES_OBSERVE_OBSERVED_JOURNAL_H_
#define CORBSLAM_SERVICES_OBSERVE_OBSERVED_JOURNAL_H_

#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "map_store/records/journal.h"

namespace corbslam::services {

// Hears of a journal, on the threads that use it, several at once; its functions must return soon.
class JournalObserver {
 public:
  virtual ~JournalObserver() = default;
  // Called when the record is part of the mission, unless `status` says that it was not written.
  virtual void OnAppended(absl::string_view mission, const map_store::JournalRecord& record,
                          absl::Duration took, const absl::Status& status) = 0;
  virtual void OnSynced(absl::Duration took, const absl::Status& status) = 0;
  virtual void OnSnapshot(absl::Duration took, const absl::Status& status) = 0;
  // Called each time that somebody asked whether the journal takes records.
  virtual void OnChecked(const absl::Status& writable) = 0;
};

// Makes a journal that owns `journal`. `observers` (not owned) must outlive the result. They don't
// hear what Recover reads.
std::unique_ptr<map_store::Journal> MakeObservedJournal(std::unique_ptr<map_store::Journal> journal,
                                                        std::vector<JournalObserver*> observers);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_OBSERVED_JOURNAL_H_
