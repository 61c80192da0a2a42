#include "map_store/mission/scale_contradictions.h"

#include <cmath>
#include <optional>

namespace corbslam::map_store {
namespace {

std::optional<uint64_t> FindLink(const LocalMapState& a, const LocalMapState& b,
                                 const OverlapLedger& overlaps) {
  for (const LocalMapId& name_a : a.Names()) {
    for (const LocalMapId& name_b : b.Names()) {
      const OverlapLedger::Ids& live = overlaps.LiveBetween(name_a, name_b);
      if (!live.empty()) return *live.begin();
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<ContradictedOverlap> FindContradicted(
    const MissionState& state, const std::string& agent,
    const std::vector<ScaleContradiction>& contradictions) {
  std::vector<ContradictedOverlap> found;
  for (const ScaleContradiction& contradiction : contradictions) {
    if (std::abs(contradiction.scale - 1) <= kToleratedScale) continue;
    const LocalMapState* others = state.FindLocalMap(state.OwnerOf(contradiction.local_map));
    if (others == nullptr || others->agent == agent) continue;
    for (const LocalMapId& id : state.order) {
      const LocalMapState& own = *state.FindLocalMap(id);
      // What the agent made before may be of another calibration.
      if (own.agent != agent || own.closed) continue;
      if (const auto link = FindLink(own, *others, state.global.overlaps)) {
        found.push_back({*link, own.id, others->id, contradiction.scale});
      }
    }
  }
  return found;
}

}  // namespace corbslam::map_store
