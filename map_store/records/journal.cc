#include "map_store/records/journal.h"

namespace corbslam::map_store {

absl::StatusOr<Journal::Position> InMemoryJournal::Append(absl::string_view, const JournalRecord&) {
  absl::MutexLock lock(&mutex_);
  return ++records_;
}

uint64_t InMemoryJournal::records() const {
  absl::MutexLock lock(&mutex_);
  return records_;
}

}  // namespace corbslam::map_store
