#include "map_store/retiring/retirement.h"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "absl/strings/str_cat.h"
#include "map_store/ingest/change_recording.h"
#include "map_store/ingest/graph_changes.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

using MapPointIds = absl::flat_hash_set<MapPointId>;

absl::Status Unfounded(const std::string& what) {
  return absl::DataLossError(absl::StrCat("a retirement of ", what));
}

absl::Status CheckClosed(const MissionState& state, LocalMapId id) {
  const LocalMapState* local_map = state.FindLocalMap(id);
  if (local_map != nullptr && local_map->closed) return absl::OkStatus();
  return Unfounded(absl::StrCat("parts of local map ", ToString(id), ", which is not closed"));
}

absl::Status CheckKeyframe(const RetiredKeyframe& retired, const std::set<KeyframeId>& going,
                           const MissionState& state) {
  RETURN_IF_ERROR(CheckClosed(state, retired.id.local_map));
  if (state.FindKeyframe(retired.id) == nullptr) {
    return Unfounded(absl::StrCat("keyframe ", ToString(retired.id), ", which is not there"));
  }
  const KeyframeId stand_in = retired.stand_in.keyframe;
  const bool stays = state.FindLocalMap(retired.id.local_map)->IsNamed(retired.parent.local_map) &&
                     state.FindKeyframe(retired.parent) != nullptr &&
                     state.FindKeyframe(stand_in) != nullptr && !going.contains(retired.parent) &&
                     !going.contains(stand_in);
  const bool joined = stays && state.global.island_of.at(stand_in.local_map) ==
                                   state.global.island_of.at(retired.id.local_map);
  if (joined) return absl::OkStatus();
  return Unfounded(absl::StrCat("keyframe ", ToString(retired.id), " in favour of ",
                                ToString(retired.parent), " and ", ToString(stand_in),
                                ", which don't stay in its island"));
}

// Points of its own local map that follow or are seen by the keyframe.
std::vector<MapPointId> OwnPointsOf(KeyframeId id, LocalMapState& local_map) {
  const auto follows = [&](MapPointId point) { return local_map.map.FindPoint(point) != nullptr; };
  std::vector<MapPointId> points = local_map.followers.Of(id, follows);
  for (const MapPointId& point : local_map.map.FindKeyframe(id)->points) {
    if (point.IsValid()) points.push_back(point);
  }
  return points;
}

// Has points that followed the keyframe, which is gone, follow another one that sees them.
void FollowAnother(KeyframeId gone, const std::vector<MapPointId>& points,
                   const GlobalLayer& global, LocalMapState& local_map) {
  for (const MapPointId& id : points) {
    const MapPoint* point = local_map.map.FindPoint(id);
    if (point == nullptr || point->reference != gone || point->observations.empty()) continue;
    KeyframeId next = point->observations.begin()->first;
    for (const auto& [keyframe, keypoint] : point->observations) {
      if (!global.keyframes.contains(keyframe)) continue;
      next = keyframe;
      break;
    }
    local_map.map.SetPointAppearance(id, point->descriptor, point->normal_in_map,
                                     point->min_distance, point->max_distance, next);
    local_map.followers.Add(next, id);
  }
}

uint64_t BytesOf(const Keyframe& keyframe) {
  return sizeof(Keyframe) + keyframe.points.size() * (sizeof(Keypoint) + sizeof(Descriptor));
}

void ForgetBytes(uint64_t bytes, LocalMapState& local_map) {
  local_map.stored_bytes -= std::min(local_map.stored_bytes, bytes);
}

void Remove(const RetiredKeyframe& retired, MissionState& state) {
  LocalMapState& local_map = *state.FindLocalMap(retired.id.local_map);
  const std::vector<MapPointId> points = OwnPointsOf(retired.id, local_map);
  ForgetBytes(BytesOf(*local_map.map.FindKeyframe(retired.id)), local_map);
  ApplyKeyframeRemoval({retired.id, retired.parent, retired.parent_from_removed}, state, local_map);
  FollowAnother(retired.id, points, state.global, local_map);
  state.global.stand_ins[retired.id] = retired.stand_in;
  ++local_map.retired_keyframes;
  Island& island = *state.FindIslandOf(local_map.id);
  island.adjusted -= std::min<size_t>(island.adjusted, 1);
  island.moved.erase(retired.id);
}

// Returns the points that no keyframe of their own local map sees without those that go.
std::set<MapPointId> FindUnseen(const Retirement& retirement, MissionState& state) {
  absl::flat_hash_set<KeyframeId> going;
  for (const RetiredKeyframe& retired : retirement.keyframes) going.insert(retired.id);
  std::set<MapPointId> unseen;
  for (const RetiredKeyframe& retired : retirement.keyframes) {
    LocalMapState& local_map = *state.FindLocalMap(retired.id.local_map);
    for (const MapPointId& id : OwnPointsOf(retired.id, local_map)) {
      const bool is_seen =
          std::ranges::any_of(local_map.map.FindPoint(id)->observations,
                              [&going](const auto& seen) { return !going.contains(seen.first); });
      if (!is_seen) unseen.insert(id);
    }
  }
  return unseen;
}

void RemovePoint(MapPointId id, MissionState& state) {
  LocalMapState& local_map = *state.FindLocalMap(id.local_map);
  if (local_map.map.FindPoint(id) == nullptr) return;
  ApplyPointRemoval(id, state, local_map);
  ForgetBytes(sizeof(MapPoint), local_map);
}

std::set<LocalMapId> LocalMapsOf(const Retirement& retirement) {
  std::set<LocalMapId> local_maps;
  for (const RetiredKeyframe& retired : retirement.keyframes) {
    local_maps.insert(retired.id.local_map);
  }
  for (const MapPointId& point : retirement.faded) local_maps.insert(point.local_map);
  return local_maps;
}

}  // namespace

absl::Status CheckRetirement(const Retirement& retirement, const MissionState& state) {
  std::set<KeyframeId> going;
  for (const RetiredKeyframe& retired : retirement.keyframes) {
    if (!going.insert(retired.id).second) {
      return Unfounded(absl::StrCat("keyframe ", ToString(retired.id), " twice"));
    }
  }
  for (const RetiredKeyframe& retired : retirement.keyframes) {
    RETURN_IF_ERROR(CheckKeyframe(retired, going, state));
  }
  for (const MapPointId& point : retirement.faded) {
    RETURN_IF_ERROR(CheckClosed(state, point.local_map));
  }
  return absl::OkStatus();
}

void ApplyRetirement(const Retirement& retirement, MissionState& state) {
  const std::set<LocalMapId> local_maps = LocalMapsOf(retirement);
  std::vector<std::unique_ptr<ChangeRecorder>> recorders;
  recorders.reserve(local_maps.size());
  for (const LocalMapId& id : local_maps) {
    recorders.push_back(std::make_unique<ChangeRecorder>(*state.FindLocalMap(id)));
  }
  NoteLandmarkChanges(MapPointIds(retirement.faded.begin(), retirement.faded.end()), state);
  for (const MapPointId& point : retirement.faded) {
    LocalMapState& owner = *state.FindLocalMap(point.local_map);
    owner.faded_points += owner.map.FindPoint(point) != nullptr;
    RemovePoint(point, state);
  }
  // They go before their keyframes do, so that their heirs take over their places.
  const std::set<MapPointId> unseen = FindUnseen(retirement, state);
  NoteLandmarkChanges(MapPointIds(unseen.begin(), unseen.end()), state);
  for (const MapPointId& point : unseen) RemovePoint(point, state);
  for (const RetiredKeyframe& retired : retirement.keyframes) Remove(retired, state);
  recorders.clear();
  std::set<IslandId> islands;
  for (const LocalMapId& id : local_maps) islands.insert(state.global.island_of.at(id));
  for (const IslandId& id : islands) TouchByRetirement(state, id, local_maps);
}

}  // namespace corbslam::map_store
