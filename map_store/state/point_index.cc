#include "map_store/state/point_index.h"

#include <utility>

#include "absl/container/flat_hash_set.h"
#include "slam/util/heap_bytes.h"

namespace corbslam::map_store {

void PointIndex::AddViewer(MapPointId point, KeyframeId keyframe, uint32_t keypoint) {
  sights_ += viewers_[point].try_emplace(keyframe, keypoint).second ? 1 : 0;
}

void PointIndex::RemoveViewer(MapPointId point, KeyframeId keyframe, uint32_t keypoint) {
  const auto it = viewers_.find(point);
  if (it == viewers_.end()) return;
  const auto viewer = it->second.find(keyframe);
  if (viewer == it->second.end() || viewer->second != keypoint) return;
  it->second.erase(viewer);
  --sights_;
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

uint64_t PointIndex::HeapBytes() const {
  using Viewers = decltype(viewers_)::value_type;
  using Viewer = decltype(viewers_)::mapped_type::value_type;
  using Replaced = decltype(replaced_by_)::value_type;
  const uint64_t points = viewers_.size();
  const uint64_t viewers_each = points == 0 ? 0 : (sights_ + points / 2) / points;
  return HashTableBytes<Viewers>(points) + points * BtreeBytes<Viewer>(viewers_each) +
         HashTableBytes<Replaced>(replaced_by_.size()) +
         replaced_by_.size() * HeapBlockBytes(sizeof(MapPointId));
}

}  // namespace corbslam::map_store
