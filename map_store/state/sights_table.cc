#include "map_store/state/sights_table.h"

#include "slam/util/heap_bytes.h"

namespace corbslam::map_store {

std::shared_ptr<const Sights> SightsTable::Share(KeyframeId keyframe, Sights sights) const {
  absl::MutexLock lock(&mutex_);
  if (newest_.size() >= tidy_at_) {
    absl::erase_if(newest_, [](const auto& entry) { return entry.second.expired(); });
    tidy_at_ = 1000 + 2 * newest_.size();
  }
  std::weak_ptr<const Sights>& newest = newest_[keyframe];
  if (auto same = newest.lock(); same != nullptr && *same == sights) return same;
  sights.shrink_to_fit();
  // make_shared is not used, since the table's weak pointer would keep the sights' memory.
  std::shared_ptr<const Sights> shared(new Sights(std::move(sights)));
  newest = shared;
  return shared;
}

uint64_t SightsTable::HeapBytes() const {
  absl::MutexLock lock(&mutex_);
  return HashTableBytes<decltype(newest_)::value_type>(newest_.size());
}

}  // namespace corbslam::map_store
