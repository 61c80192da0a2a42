#include "map_store/sharing/share_news.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace corbslam::map_store {
namespace {

// Returns all content of the local map, any of which may have changed. Points that were not sent
// are no news (AddChanges), so that only the agent's own map lists all of its points.
ItemChanges ContentOf(const LocalMapState& local_map, const ShareState& share) {
  ItemChanges content;
  for (const auto& [id, keyframe] : local_map.map.keyframes()) content.keyframes.push_back(id);
  content.sights = content.keyframes;
  for (const LocalMapId& name : local_map.Names()) {
    for (auto it = share.keyframes.lower_bound(KeyframeId{name, 0});
         it != share.keyframes.end() && it->first.local_map == name; ++it) {
      if (local_map.map.FindKeyframe(it->first) == nullptr) content.keyframes.push_back(it->first);
    }
  }
  if (local_map.id == share.local_map) {
    for (const auto& [id, point] : local_map.map.points()) content.landmarks.push_back(id);
    return content;
  }
  for (const LocalMapId& name : local_map.Names()) {
    for (auto it = share.points.lower_bound(MapPointId{name, 0});
         it != share.points.end() && it->first.local_map == name; ++it) {
      content.points.push_back(it->first);
    }
  }
  content.landmarks = content.points;
  return content;
}

ItemChanges FindChanges(const LocalMapState& local_map, const ShareState& share) {
  std::optional<ItemChanges> changes;
  if (share.seen_local_maps.contains(local_map.id) && !share.look_at_all) {
    changes = local_map.changes.Since(share.seen_version);
  }
  if (!changes.has_value()) changes = ContentOf(local_map, share);
  return *std::move(changes);
}

// Adds changes of what the agent has. What it does not have is no news, since it is sent as it is
// then.
void AddChanges(const ItemChanges& changes, bool is_own, ShareState& share) {
  ShareNews& news = share.news;
  if (is_own) {
    news.landmarks.insert(changes.landmarks.begin(), changes.landmarks.end());
    return;
  }
  for (const MapPointId& id : changes.landmarks) {
    if (share.points.contains(id)) news.landmarks.insert(id);
  }
  news.keyframes.insert(changes.keyframes.begin(), changes.keyframes.end());
  for (const KeyframeId& id : changes.sights) {
    if (share.keyframes.contains(id)) news.sights.insert(id);
  }
  for (const MapPointId& id : changes.points) {
    if (share.points.contains(id)) news.points.insert(id);
  }
}

// Adds everything that has a place, since fusion may have moved it.
void AddPlaces(ShareState& share) {
  ShareNews& news = share.news;
  news.own_keyframes = true;
  for (const auto& [id, sent] : share.keyframes) news.keyframes.insert(news.keyframes.end(), id);
  for (const KeyframeId id : share.far.TakeAll()) news.keyframes.insert(id);
  news.points.clear();
  news.all_points_from = MapPointId{LocalMapId{0}, 0};
}

}  // namespace

std::vector<LocalMapId> CollectNews(const MissionState& state, const Island& island,
                                    ShareState& share) {
  std::vector<LocalMapId> changed;
  for (const LocalMapId& id : island.local_maps) {
    const LocalMapState& local_map = *state.FindLocalMap(id);
    const ItemChanges changes = FindChanges(local_map, share);
    if (changes.size() == 0) continue;
    changed.push_back(id);
    AddChanges(changes, id == share.local_map, share);
  }
  if (share.seen_revision != state.global.revision) AddPlaces(share);
  share.look_at_all = false;
  share.seen_version = state.version;
  share.seen_revision = state.global.revision;
  share.seen_local_maps = {island.local_maps.begin(), island.local_maps.end()};
  return changed;
}

}  // namespace corbslam::map_store
