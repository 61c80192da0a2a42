#include "map_store/ingest/anchoring.h"

#include <optional>

#include "map_store/view/placement.h"

namespace corbslam::map_store {
namespace {

void PlaceAgain(const LostPlace& place, MissionState& state) {
  const MapPoint* point = state.FindPoint(place.id);
  if (point == nullptr) return;
  const auto placed = Anchor(*point, place.position_in_island, place.revision, state.global,
                             state.global.keyframes);
  if (placed.has_value()) state.global.points.try_emplace(place.id, *placed);
}

}  // namespace

std::vector<LostPlace> TakePlaces(KeyframeId id, GlobalLayer& global, LocalMapState& local_map) {
  const Keyframe* keyframe = local_map.map.FindKeyframe(id);
  if (keyframe == nullptr || !global.keyframes.contains(id)) return {};
  const auto follows = [&](MapPointId point) { return local_map.map.FindPoint(point) != nullptr; };
  std::vector<MapPointId> points = local_map.followers.Of(id, follows);
  points.insert(points.end(), keyframe->points.begin(), keyframe->points.end());
  std::vector<LostPlace> lost;
  for (const MapPointId& point : points) {
    const std::optional<PlacedAnchor> placed = FindPlaced(point, global);
    if (!placed.has_value() || placed->point->anchor != id) continue;
    lost.push_back({point, placed->PositionInIsland(), placed->revision()});
    global.points.erase(point);
  }
  return lost;
}

void AnchorElsewhere(const std::vector<LostPlace>& lost, MissionState& state) {
  for (const LostPlace& place : lost) PlaceAgain(place, state);
}

void HandOverPlace(MapPointId from, MapPointId to, MissionState& state) {
  if (const std::optional<PlacedAnchor> placed = FindPlaced(from, state.global)) {
    PlaceAgain({to, placed->PositionInIsland(), placed->revision()}, state);
  }
  state.global.points.erase(from);
}

}  // namespace corbslam::map_store
