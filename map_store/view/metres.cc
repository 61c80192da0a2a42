#include "map_store/view/metres.h"

#include <algorithm>

namespace corbslam::map_store {

bool IsInMetres(const LocalMapState& local_map) {
  return !local_map.cameras.empty() &&
         std::ranges::all_of(local_map.cameras,
                             [](const auto& camera) { return camera->IsMetric(); });
}

bool IsInMetres(const MissionState& state, const Island& island) {
  return std::ranges::any_of(island.local_maps, [&state](LocalMapId id) {
    const LocalMapState* const local_map = state.FindLocalMap(id);
    return local_map != nullptr && IsInMetres(*local_map);
  });
}

}  // namespace corbslam::map_store
