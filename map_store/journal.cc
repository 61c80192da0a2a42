#include "map_store/journal.h"

namespace corbslam {

absl::Status InMemoryJournal::Append(const JournalRecord&) {
  absl::MutexLock lock(&mutex_);
  ++records_;
  return absl::OkStatus();
}

uint64_t InMemoryJournal::records() const {
  absl::MutexLock lock(&mutex_);
  return records_;
}

}  // namespace corbslam
