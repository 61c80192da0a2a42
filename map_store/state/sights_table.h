// Keeps what keyframes see, by names of the global layer, once for all agents who were told the
// same.
#ifndef CORBSLAM_MAP_STORE_STATE_SIGHTS_TABLE_H_
#define CORBSLAM_MAP_STORE_STATE_SIGHTS_TABLE_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/container/flat_hash_map.h"
#include "absl/synchronization/mutex.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Pairs of keypoint and landmark, by keypoint; keypoints that see no landmark are left out.
using Sights = std::vector<std::pair<uint32_t, MapPointId>>;

// The newest sights of each keyframe that are in use. It is thread-safe, keeps nothing alive by
// itself, and forgets what nobody uses. A copy begins empty.
class SightsTable {
 public:
  SightsTable() = default;
  SightsTable(const SightsTable&) {}
  SightsTable(SightsTable&&) noexcept {}
  SightsTable& operator=(const SightsTable&) { return *this; }
  SightsTable& operator=(SightsTable&&) noexcept { return *this; }
  ~SightsTable() = default;

  // Returns `sights`, or the ones that were shared last for the keyframe if they are the same and
  // somebody still has them.
  std::shared_ptr<const Sights> Share(KeyframeId keyframe, Sights sights) const;
  // Returns about how much of the heap it takes, without the sights, which others have of it.
  uint64_t HeapBytes() const;

 private:
  mutable absl::Mutex mutex_;
  mutable absl::flat_hash_map<KeyframeId, std::weak_ptr<const Sights>> newest_
      ABSL_GUARDED_BY(mutex_);
  mutable size_t tidy_at_ ABSL_GUARDED_BY(mutex_) = 1000;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_SIGHTS_TABLE_H_
