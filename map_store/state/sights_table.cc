#include "map_store/state/sights_table.h"

namespace corbslam::map_store {

std::shared_ptr<const Sights> SightsTable::Share(KeyframeId keyframe, Sights sights) const {
  absl::MutexLock lock(&mutex_);
  std::weak_ptr<const Sights>& newest = newest_[keyframe];
  if (auto same = newest.lock(); same != nullptr && *same == sights) return same;
  sights.shrink_to_fit();
  // make_shared is not used, since the table's weak pointer would keep the sights' memory.
  std::shared_ptr<const Sights> shared(new Sights(std::move(sights)));
  newest = shared;
  return shared;
}

}  // namespace corbslam::map_store
