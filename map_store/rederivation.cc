#include "map_store/rederivation.h"

#include <utility>

namespace corbslam::map_store {

Island MakeLoneIsland(const MissionState& state, LocalMapId id) {
  Island island;
  island.id = id;
  island.local_maps = {id};
  // Jobs that run on the old one find a newer one.
  island.generation = state.FindIslandOf(id)->generation + 1;
  island.dirty = true;
  island.version = state.version;
  island.version_of_owners = state.version;
  island.shared_version = state.version;
  return island;
}

void ForgetGlobalLayer(MissionState& state) {
  GlobalLayer fresh;
  fresh.revision = state.global.revision + 1;
  fresh.taken_back = std::move(state.global.taken_back);
  fresh.kept_apart = std::move(state.global.kept_apart);
  ++state.version;
  for (const LocalMapId& id : state.order) {
    fresh.island_of[id] = id;
    fresh.islands[id] = MakeLoneIsland(state, id);
  }
  state.global = std::move(fresh);
  state.queries.clear();
  // Of two keyframes the one that comes later asks.
  for (auto at = state.local_maps.begin(); at != state.local_maps.end(); ++at) {
    for (const auto& [keyframe, item] : at->second.map.keyframes()) {
      if (!at->second.IsSettled(keyframe)) continue;
      for (auto against = state.local_maps.begin(); against != state.local_maps.end(); ++against) {
        state.queries.push_back({keyframe, against->first, 0});
        if (against == at) break;
      }
    }
  }
}

}  // namespace corbslam::map_store
