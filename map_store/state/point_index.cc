#include "map_store/state/point_index.h"

#include "absl/container/flat_hash_set.h"

namespace corbslam::map_store {

void PointIndex::AddViewer(MapPointId point, KeyframeId keyframe, uint32_t keypoint) {
  viewers_[point].try_emplace(keyframe, keypoint);
}

void PointIndex::RemoveViewer(MapPointId point, KeyframeId keyframe, uint32_t keypoint) {
  const auto it = viewers_.find(point);
  if (it == viewers_.end()) return;
  const auto viewer = it->second.find(keyframe);
  if (viewer == it->second.end() || viewer->second != keypoint) return;
  it->second.erase(viewer);
  if (it->second.empty()) viewers_.erase(it);
}

std::vector<KeyframeId> PointIndex::ViewersOf(MapPointId point) const {
  std::vector<KeyframeId> viewers;
  const auto it = viewers_.find(point);
  if (it == viewers_.end()) return viewers;
  for (const auto& [keyframe, keypoint] : it->second) viewers.push_back(keyframe);
  return viewers;
}

std::optional<uint32_t> PointIndex::FindSight(MapPointId point, KeyframeId keyframe) const {
  const auto it = viewers_.find(point);
  if (it == viewers_.end()) return std::nullopt;
  const auto viewer = it->second.find(keyframe);
  if (viewer == it->second.end()) return std::nullopt;
  return viewer->second;
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
