#include "map_store/sharing/share_news.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace corbslam::map_store {
namespace {

// All of it may have changed.
ItemChanges ContentOf(const Map& map) {
  ItemChanges content;
  for (const auto& [id, keyframe] : map.keyframes()) content.keyframes.push_back(id);
  content.sights = content.keyframes;
  for (const auto& [id, point] : map.points()) content.points.push_back(id);
  content.landmarks = content.points;
  return content;
}

ItemChanges FindChanges(const LocalMapState& local_map, const ShareState& share) {
  std::optional<ItemChanges> changes;
  if (share.seen_local_maps.contains(local_map.id)) {
    changes = local_map.changes.Since(share.seen_version);
  }
  if (!changes.has_value()) changes = ContentOf(local_map.map);
  return *std::move(changes);
}

// What the agent does not have is sent as it is then: no news of that.
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

// Fusion may have moved anything.
void AddPlaces(ShareState& share) {
  ShareNews& news = share.news;
  news.own_keyframes = true;
  for (const auto& [id, sent] : share.keyframes) news.keyframes.insert(news.keyframes.end(), id);
  std::vector<MapPointId> points;
  points.reserve(share.points.size());
  for (const auto& [id, sent] : share.points) points.push_back(id);
  std::sort(points.begin(), points.end());
  for (const MapPointId& id : points) news.points.insert(news.points.end(), id);
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
  share.seen_version = state.version;
  share.seen_revision = state.global.revision;
  share.seen_local_maps = {island.local_maps.begin(), island.local_maps.end()};
  return changed;
}

}  // namespace corbslam::map_store
