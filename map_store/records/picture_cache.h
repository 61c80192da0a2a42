// Holds the newest pictures of keyframes in memory, for a store that has no disk.
#ifndef CORBSLAM_MAP_STORE_RECORDS_PICTURE_CACHE_H_
#define CORBSLAM_MAP_STORE_RECORDS_PICTURE_CACHE_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/container/flat_hash_map.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "map_store/records/picture_book.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// Thread-safe.
class PictureCache {
 public:
  // Bytes of all missions' pictures; what comes beyond is not kept.
  static constexpr uint64_t kMaxBytes = 64 << 20;

  // Keeps the picture, unless its keyframe has one or all missions have too many. Beyond
  // `max_bytes` the mission's oldest go.
  void Put(absl::string_view mission, const KeyframePicture& picture, uint64_t max_bytes)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // NOT_FOUND, naming the keyframe.
  absl::StatusOr<KeyframePicture> Read(absl::string_view mission, KeyframeId keyframe) const
      ABSL_LOCKS_EXCLUDED(mutex_);
  void Remove(absl::string_view mission, const std::vector<KeyframeId>& keyframes)
      ABSL_LOCKS_EXCLUDED(mutex_);
  void RemoveMission(absl::string_view mission) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct OfMission {
    PictureBook book;
    absl::flat_hash_map<KeyframeId, KeyframePicture> pictures;
  };

  mutable absl::Mutex mutex_;
  std::map<std::string, OfMission> missions_ ABSL_GUARDED_BY(mutex_);
  uint64_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_PICTURE_CACHE_H_
