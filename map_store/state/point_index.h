// Says who sees a point, and by which names, so that what changes with a point is found without
// looking at all observations.
#ifndef CORBSLAM_MAP_STORE_STATE_POINT_INDEX_H_
#define CORBSLAM_MAP_STORE_STATE_POINT_INDEX_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/container/flat_hash_map.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Viewers and names of points. It is derived from what the owners say, and never written down. A
// value; not thread-safe.
class PointIndex {
 public:
  // Notes that a keypoint of the keyframe sees the point, which is another local map's, as the
  // keyframe's owner says. A keyframe sees a point by one keypoint: the first one counts.
  void AddViewer(MapPointId point, KeyframeId keyframe, uint32_t keypoint);
  void RemoveViewer(MapPointId point, KeyframeId keyframe, uint32_t keypoint);
  // Returns the keyframes that see the point, in the order of their ids.
  std::vector<KeyframeId> ViewersOf(MapPointId point) const;
  // Returns the keypoint by which the keyframe sees the point; nullopt if it doesn't.
  std::optional<uint32_t> FindSight(MapPointId point, KeyframeId keyframe) const;

  // The caller says that whoever sees `replaced` sees `by` from now on. That is never taken back,
  // as ids never return.
  void NoteReplaced(MapPointId replaced, MapPointId by);
  // Returns the point, and all points that were replaced by it, directly or one after the other.
  std::vector<MapPointId> NamesOf(MapPointId point) const;

  // Returns about how much of the heap it takes.
  uint64_t HeapBytes() const;

 private:
  absl::flat_hash_map<MapPointId, absl::btree_map<KeyframeId, uint32_t>> viewers_;
  absl::flat_hash_map<MapPointId, std::vector<MapPointId>> replaced_by_;
  uint64_t sights_ = 0;  // Entries of `viewers_`, of all points.
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_POINT_INDEX_H_
