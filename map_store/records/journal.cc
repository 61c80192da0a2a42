#include "map_store/records/journal.h"

namespace corbslam::map_store {

std::vector<KeyframeId> RemovedBy(const JournalRecord& record) {
  std::vector<KeyframeId> removed;
  const auto* update = std::get_if<BatchRecord>(&record);
  if (update == nullptr) return removed;
  for (const KeyframeRemoval& removal : update->batch->removed_keyframes) {
    removed.push_back(removal.id);
  }
  return removed;
}

absl::StatusOr<Journal::Position> InMemoryJournal::Append(absl::string_view mission,
                                                          const JournalRecord& record) {
  pictures_.Remove(mission, RemovedBy(record));
  absl::MutexLock lock(&mutex_);
  return ++records_;
}

uint64_t InMemoryJournal::records() const {
  absl::MutexLock lock(&mutex_);
  return records_;
}

}  // namespace corbslam::map_store
