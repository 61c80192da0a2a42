#include "map_store/ingest/settling.h"

namespace corbslam::map_store {

void SettleKeyframes(size_t settle_after, MissionState& state, LocalMapState& local_map) {
  const size_t arrived = local_map.arrived.size();
  const size_t provisional = local_map.closed ? 0 : settle_after;
  for (; local_map.settled + provisional < arrived; ++local_map.settled) {
    const KeyframeId id = local_map.arrived[local_map.settled];
    if (local_map.map.FindKeyframe(id) == nullptr) continue;
    ++state.statistics.overlaps_queried;
    state.queries.Push(id, state.order);
    state.queries.ThinOut(local_map.id);
  }
  if (!local_map.closed) return;
  state.queries.ThinOutEnded(local_map.id, [&state](LocalMapId id) {
    const LocalMapState* waiting = state.FindLocalMap(id);
    return waiting != nullptr && waiting->closed;
  });
}

}  // namespace corbslam::map_store
