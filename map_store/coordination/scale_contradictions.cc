#include "map_store/coordination/scale_contradictions.h"

#include <cmath>

#include "map_store/records/retraction.h"

namespace corbslam::map_store {

std::vector<ContradictedOverlap> FindContradicted(
    const MissionState& state, const std::string& agent,
    const std::vector<MapContradiction>& contradictions) {
  std::vector<ContradictedOverlap> found;
  for (const MapContradiction& contradiction : contradictions) {
    if (std::abs(contradiction.scale - 1) <= kToleratedScale) continue;
    const LocalMapState* others = state.FindLocalMap(state.OwnerOf(contradiction.local_map));
    if (others == nullptr || others->agent == agent) continue;
    for (const LocalMapId& id : state.order) {
      const LocalMapState& own = *state.FindLocalMap(id);
      // What the agent made before may be of another calibration.
      if (own.agent != agent || own.closed) continue;
      const std::vector<uint64_t> links = FindLinks(own, *others, state.global.overlaps);
      if (links.empty()) continue;
      found.push_back({links.front(), own.id, others->id, contradiction.scale});
    }
  }
  return found;
}

}  // namespace corbslam::map_store
