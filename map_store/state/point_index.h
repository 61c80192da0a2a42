// Who sees a point, and by which names: what changes with a point is found without looking at all
// that anybody sees.
#ifndef CORBSLAM_MAP_STORE_STATE_POINT_INDEX_H_
#define CORBSLAM_MAP_STORE_STATE_POINT_INDEX_H_

#include <span>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Derived from what the owners say, and never written down.
class PointIndex {
 public:
  // The keyframe's owner says that it sees the point, which is another local map's.
  void AddViewer(MapPointId point, KeyframeId keyframe);
  void RemoveViewer(MapPointId point, KeyframeId keyframe);
  // In the order in which they came, each as often as it sees the point.
  std::span<const KeyframeId> ViewersOf(MapPointId point) const;

  // Whoever sees `replaced` sees `by` from now on. That is never taken back, as ids never return.
  void NoteReplaced(MapPointId replaced, MapPointId by);
  // The point, and all that were replaced by it, directly or one after the other.
  std::vector<MapPointId> NamesOf(MapPointId point) const;

 private:
  absl::flat_hash_map<MapPointId, std::vector<KeyframeId>> viewers_;
  absl::flat_hash_map<MapPointId, std::vector<MapPointId>> replaced_by_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_POINT_INDEX_H_
