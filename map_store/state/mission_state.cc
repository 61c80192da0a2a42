#include "map_store/state/mission_state.h"

#include <algorithm>

namespace corbslam::map_store {
namespace {

// No honest owner makes a chain of replacements as long as this.
constexpr int kMaxChain = 1000;

}  // namespace

MapPointId ResolvePoint(const MissionState& state, MapPointId point) {
  for (int step = 0; step < kMaxChain; ++step) {
    const LocalMapState* owner = state.FindLocalMap(point.local_map);
    if (owner == nullptr) {
      // Points of a local map that was deleted may have heirs.
      const auto heir = state.global.heirs.find(point);
      if (heir == state.global.heirs.end()) return MapPointId();
      point = heir->second;
      continue;
    }
    const auto replaced = owner->replaced_points.find(point);
    if (replaced == owner->replaced_points.end()) {
      if (owner->map.FindPoint(point) != nullptr) return state.global.landmarks.Survivor(point);
      const auto heir = state.global.heirs.find(point);
      if (heir == state.global.heirs.end()) return MapPointId();
      point = heir->second;
    } else {
      point = replaced->second;
    }
  }
  return MapPointId();
}

MapPointId RawObservation(const LocalMapState& local_map, KeyframeId keyframe_id,
                          uint32_t keypoint) {
  const Keyframe* keyframe = local_map.map.FindKeyframe(keyframe_id);
  if (keyframe == nullptr || keypoint >= keyframe->points.size()) return MapPointId();
  if (keyframe->points[keypoint].IsValid()) return keyframe->points[keypoint];
  const auto foreign = local_map.foreign_observations.find(keyframe_id);
  if (foreign == local_map.foreign_observations.end()) return MapPointId();
  const auto it = foreign->second.find(keypoint);
  return it == foreign->second.end() ? MapPointId() : it->second;
}

namespace {

void CloseChangeLogs(const Island& island, MissionState& state) {
  for (const LocalMapId& id : island.local_maps) {
    LocalMapState& local_map = *state.FindLocalMap(id);
    const Map& map = local_map.map;
    local_map.changes.Close(state.version, map.keyframes().size() + map.points().size());
  }
}

}  // namespace

size_t CountKeyframes(const MissionState& state, const Island& island) {
  size_t count = 0;
  for (const LocalMapId& id : island.local_maps) {
    count += state.FindLocalMap(id)->map.keyframes().size();
  }
  return count;
}

uint64_t LastBatchOf(const MissionState& state, LocalMapId id) {
  if (const auto gone = state.forgotten.find(id); gone != state.forgotten.end()) {
    return gone->second;
  }
  const LocalMapState* local_map = state.FindLocalMap(id);
  if (local_map == nullptr) return 0;
  const auto part = std::ranges::find(local_map->joined, id, &JoinedLocalMap::id);
  return part == local_map->joined.end() ? local_map->last_batch : part->last_batch;
}

void SetIslandOf(const LocalMapState& local_map, IslandId island, MissionState& state) {
  for (const LocalMapId& name : local_map.Names()) state.global.island_of[name] = island;
}

void IndexJoined(MissionState& state) {
  state.joined_into.clear();
  for (auto& [id, local_map] : state.local_maps) {
    local_map.part_names.clear();
    for (const JoinedLocalMap& part : local_map.joined) {
      state.joined_into[part.id] = id;
      local_map.part_names.insert(part.id);
    }
  }
}

void IndexPoints(MissionState& state) {
  state.points = PointIndex();
  for (const auto& [id, local_map] : state.local_maps) {
    for (const auto& [keyframe, seen] : local_map.foreign_observations) {
      for (const auto& [keypoint, point] : seen) {
        state.points.AddViewer(point, keyframe, keypoint);
      }
    }
    for (const auto& [replaced, by] : local_map.replaced_points) {
      state.points.NoteReplaced(replaced, by);
    }
  }
  for (const auto& [removed, heir] : state.global.heirs) state.points.NoteReplaced(removed, heir);
}

void ForgetChanges(const MissionState& state, LocalMapState& local_map) {
  local_map.changes.Forget(state.version);
  local_map.places_version = state.version;
}

void NoteNewestFrames(size_t tracked, size_t lost, LocalMapState& local_map) {
  const std::vector<TrackedFrame>& frames = local_map.frames;
  for (size_t i = tracked; i < frames.size(); ++i) {
    if (frames[i].timestamp_ns < frames[local_map.newest_frame].timestamp_ns) continue;
    local_map.newest_frame = i;
  }
  for (size_t i = lost; i < local_map.lost_frames_ns.size(); ++i) {
    local_map.newest_lost_ns = std::max(local_map.newest_lost_ns, local_map.lost_frames_ns[i]);
  }
}

LocalMapState& AddLocalMap(MissionState& state, LocalMapId id, const std::string& agent) {
  LocalMapState& local_map = state.local_maps[id];
  local_map.id = id;
  local_map.agent = agent;
  local_map.order = state.order.size();
  state.order.push_back(id);
  state.arrivals.Add(id, agent);
  state.agents[agent].local_maps.push_back(id);
  state.global.island_of[id] = id;
  Island& island = state.global.islands[id];
  island.id = id;
  island.local_maps = {id};
  return local_map;
}

void TouchByOwner(MissionState& state, LocalMapId local_map, bool share) {
  Island& island = *state.FindIslandOf(local_map);
  island.version = ++state.version;
  CloseChangeLogs(island, state);
  state.FindLocalMap(local_map)->places_version = state.version;
  island.version_of_owners = island.version;
  island.dirty = true;
  if (share) island.shared_version = island.version;
}

void TouchByFusion(MissionState& state, IslandId id) {
  Island& island = state.global.islands.at(id);
  island.version = ++state.version;
  CloseChangeLogs(island, state);
  for (const LocalMapId& local_map : island.local_maps) {
    state.FindLocalMap(local_map)->places_version = state.version;
  }
  island.shared_version = island.version;
  island.dirty = true;
}

void TouchByRetirement(MissionState& state, IslandId id, const std::set<LocalMapId>& local_maps) {
  Island& island = state.global.islands.at(id);
  island.version = ++state.version;
  CloseChangeLogs(island, state);
  for (const LocalMapId& local_map : local_maps) {
    if (state.global.island_of.at(local_map) != id) continue;
    state.FindLocalMap(local_map)->places_version = state.version;
  }
  island.shared_version = island.version;
}

}  // namespace corbslam::map_store
