#include "map_store/records/journal.h"

namespace corbslam {

absl::StatusOr<Journal::Position> InMemoryJournal::Append(absl::string_view,
                                                          const map_store::JournalRecord&) {
  absl::MutexLock lock(&mutex_);
  return ++records_;
}

uint64_t InMemoryJournal::records() const {
  absl::MutexLock lock(&mutex_);
  return records_;
}

}  // namespace corbslam
