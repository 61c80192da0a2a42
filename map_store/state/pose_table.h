// Keeps where the keyframes of local maps stand in their islands, until they stand elsewhere.
#ifndef CORBSLAM_MAP_STORE_STATE_POSE_TABLE_H_
#define CORBSLAM_MAP_STORE_STATE_POSE_TABLE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Poses camera_from_island, in the camera's local units: x_in_camera = s R x_in_island + t.
using IslandPoses = std::map<KeyframeId, Similarity3d>;

// The poses of all keyframes of one local map.
struct PoseTable {
  struct Standing {
    KeyframeId id;
    bool placed = false;  // By fusion itself.
    // The version of the places at which the keyframe was seen to stand elsewhere
    // (view/visible_motion.h), and its pose then.
    uint64_t changed_at = 0;
    Similarity3d shown = {};
  };

  uint64_t version = 0;  // The version of the local map's places (LocalMapState::places_version).
  IslandPoses poses;
  std::vector<Standing> standings;  // One for each pose, in the same order.
};

// The newest table of each local map. It is thread-safe: whoever reads a mission's state may add
// what it had to compute. A copy, and what is moved to, begins empty: a table belongs to the
// versions of one state.
class PoseTables {
 public:
  PoseTables() = default;
  PoseTables(const PoseTables&) {}
  PoseTables(PoseTables&&) noexcept {}
  PoseTables& operator=(const PoseTables& other);
  PoseTables& operator=(PoseTables&& other) noexcept;
  ~PoseTables() = default;

  // Returns the table that was added last, of whatever version; null if none was.
  std::shared_ptr<const PoseTable> Find(LocalMapId local_map) const;
  void Add(LocalMapId local_map, std::shared_ptr<const PoseTable> table) const;
  // Returns about how much of the heap the tables take.
  uint64_t HeapBytes() const;

 private:
  void Clear();

  mutable absl::Mutex mutex_;
  mutable std::map<LocalMapId, std::shared_ptr<const PoseTable>> tables_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_POSE_TABLE_H_
