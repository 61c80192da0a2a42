#include "map_store/state/landmarks.h"

#include <algorithm>
#include <utility>

#include "slam/util/heap_bytes.h"

namespace corbslam::map_store {

MapPointId Landmarks::Survivor(MapPointId point) const {
  const auto it = survivor_of_.find(point);
  return it == survivor_of_.end() ? point : it->second;
}

uint64_t Landmarks::HeapBytes() const {
  return TreeBytes<Sets::value_type>(members_.size()) + TreeBytes<MapPointId>(survivor_of_.size()) +
         HashTableBytes<decltype(survivor_of_)::value_type>(survivor_of_.size());
}

MapPointId Landmarks::Merge(MapPointId survivor, MapPointId member) {
  const MapPointId winner = Survivor(survivor);
  const MapPointId loser = Survivor(member);
  if (winner == loser) return winner;
  std::set<MapPointId> moved;
  if (const auto it = members_.find(loser); it != members_.end()) {
    moved = std::move(it->second);
    members_.erase(it);
  }
  moved.insert(loser);
  for (const MapPointId& point : moved) survivor_of_[point] = winner;
  members_[winner].merge(moved);
  return winner;
}

MapPointId Landmarks::Remove(MapPointId point) {
  const auto led = members_.find(point);
  if (led == members_.end()) {
    const auto it = survivor_of_.find(point);
    if (it == survivor_of_.end()) return MapPointId();
    const MapPointId survivor = it->second;
    survivor_of_.erase(it);
    std::set<MapPointId>& members = members_[survivor];
    members.erase(point);
    if (members.empty()) members_.erase(survivor);
    return survivor;
  }
  std::set<MapPointId> left = std::move(led->second);
  members_.erase(led);
  const MapPointId elected = *left.begin();
  left.erase(left.begin());
  survivor_of_.erase(elected);
  for (const MapPointId& member : left) survivor_of_[member] = elected;
  if (!left.empty()) members_[elected] = std::move(left);
  return elected;
}

MapPointId Landmarks::Replace(MapPointId replaced, MapPointId by) {
  const MapPointId rest = Remove(replaced);
  if (!rest.IsValid()) return Survivor(by);
  return Merge(rest, by);
}

void Landmarks::Dissolve(const std::set<LocalMapId>& local_maps) {
  const auto is_of_them = [&local_maps](MapPointId point) {
    return local_maps.contains(point.local_map);
  };
  std::erase_if(members_, [&](const auto& set) {
    const auto& [survivor, members] = set;
    if (!is_of_them(survivor) && std::ranges::none_of(members, is_of_them)) return false;
    for (const MapPointId& member : members) survivor_of_.erase(member);
    return true;
  });
}

}  // namespace corbslam::map_store
