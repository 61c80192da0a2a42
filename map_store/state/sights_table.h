// What keyframes see, in the words of the global layer, kept once for all who were told the same.
#ifndef CORBSLAM_MAP_STORE_STATE_SIGHTS_TABLE_H_
#define CORBSLAM_MAP_STORE_STATE_SIGHTS_TABLE_H_

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/container/flat_hash_map.h"
#include "absl/synchronization/mutex.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Keypoint and landmark, by keypoint; keypoints that see none are left out.
using Sights = std::vector<std::pair<uint32_t, MapPointId>>;

// Thread-safe. Keeps nothing alive by itself.
class SightsTable {
 public:
  SightsTable() = default;
  SightsTable(const SightsTable&) {}
  SightsTable(SightsTable&&) noexcept {}
  SightsTable& operator=(const SightsTable&) { return *this; }
  SightsTable& operator=(SightsTable&&) noexcept { return *this; }
  ~SightsTable() = default;

  // `sights`, or what was given for the keyframe last if that is the same and somebody has it
  // still.
  std::shared_ptr<const Sights> Share(KeyframeId keyframe, Sights sights) const;

 private:
  mutable absl::Mutex mutex_;
  mutable absl::flat_hash_map<KeyframeId, std::weak_ptr<const Sights>> newest_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_SIGHTS_TABLE_H_
