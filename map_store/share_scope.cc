#include "map_store/share_scope.h"

#include <optional>

namespace corbslam::map_store {
namespace {

// All of it.
ItemChanges ContentOf(const Map& map) {
  ItemChanges content;
  for (const auto& [id, keyframe] : map.keyframes()) content.keyframes.push_back(id);
  for (const auto& [id, point] : map.points()) content.points.push_back(id);
  return content;
}

void AddLocalMap(const LocalMapState& local_map, const ShareState& share, ShareScope& scope) {
  std::optional<ItemChanges> changes;
  if (share.seen_local_maps.contains(local_map.id)) {
    changes = local_map.changes.Since(share.seen_version);
  }
  if (!changes.has_value()) changes = ContentOf(local_map.map);
  if (changes->keyframes.empty() && changes->points.empty()) return;
  scope.local_maps.insert(local_map.id);
  scope.keyframes.insert(scope.keyframes.end(), changes->keyframes.begin(),
                         changes->keyframes.end());
  scope.points.insert(scope.points.end(), changes->points.begin(), changes->points.end());
}

}  // namespace

ShareScope FindShareScope(const MissionState& state, const Island& island,
                          const ShareState& share) {
  ShareScope scope;
  scope.everything = share.seen_version == 0;
  scope.places = share.seen_revision != state.global.revision;
  if (scope.everything) return scope;
  for (const LocalMapId& id : island.local_maps) {
    AddLocalMap(*state.FindLocalMap(id), share, scope);
  }
  return scope;
}

}  // namespace corbslam::map_store
