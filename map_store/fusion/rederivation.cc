#include "map_store/fusion/rederivation.h"

#include <utility>
#include <vector>

namespace corbslam::map_store {

void QueueAgain(const LocalMapState& asking, const std::vector<LocalMapId>& against,
                MissionState& state) {
  for (const auto& [keyframe, item] : asking.map.keyframes()) {
    if (!asking.IsSettled(keyframe)) continue;
    state.queries.Push(keyframe, against);
  }
}

Island MakeLoneIsland(const MissionState& state, LocalMapId id) {
  Island island;
  island.id = id;
  island.local_maps = {id};
  // Jobs that run on the old island find a newer generation.
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
  for (auto& [id, local_map] : state.local_maps) ForgetChanges(state, local_map);
  for (const LocalMapId& id : state.order) {
    for (const LocalMapId& name : state.FindLocalMap(id)->Names()) fresh.island_of[name] = id;
    fresh.islands[id] = MakeLoneIsland(state, id);
  }
  state.global = std::move(fresh);
  state.queries.Clear();
  state.failed_queries.clear();
  // Of two keyframes the one that comes later asks about the other.
  std::vector<LocalMapId> against;
  for (const auto& [id, local_map] : state.local_maps) {
    against.push_back(id);
    QueueAgain(local_map, against, state);
  }
}

}  // namespace corbslam::map_store
