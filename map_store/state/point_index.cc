#include "map_store/state/point_index.h"

#include <algorithm>

#include "absl/container/flat_hash_set.h"

namespace corbslam::map_store {

void PointIndex::AddViewer(MapPointId point, KeyframeId keyframe) {
  viewers_[point].push_back(keyframe);
}

void PointIndex::RemoveViewer(MapPointId point, KeyframeId keyframe) {
  const auto it = viewers_.find(point);
  if (it == viewers_.end()) return;
  const auto viewer = std::ranges::find(it->second, keyframe);
  if (viewer != it->second.end()) it->second.erase(viewer);
  if (it->second.empty()) viewers_.erase(it);
}

std::span<const KeyframeId> PointIndex::ViewersOf(MapPointId point) const {
  const auto it = viewers_.find(point);
  if (it == viewers_.end()) return {};
  return it->second;
}

void PointIndex::NoteReplaced(MapPointId replaced, MapPointId by) {
  replaced_by_[by].push_back(replaced);
}

std::vector<MapPointId> PointIndex::NamesOf(MapPointId point) const {
  std::vector<MapPointId> names = {point};
  absl::flat_hash_set<MapPointId> known = {point};
  for (size_t i = 0; i < names.size(); ++i) {
    const auto it = replaced_by_.find(names[i]);
    if (it == replaced_by_.end()) continue;
    for (const MapPointId& name : it->second) {
      if (known.insert(name).second) names.push_back(name);
    }
  }
  return names;
}

}  // namespace corbslam::map_store
