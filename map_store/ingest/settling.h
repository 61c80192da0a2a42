// Settles keyframes: the newest of a local map are provisional until its robot has adjusted them.
#ifndef CORBSLAM_MAP_STORE_INGEST_SETTLING_H_
#define CORBSLAM_MAP_STORE_INGEST_SETTLING_H_

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Settles all but the newest `settle_after` keyframes that ever arrived; all keyframes of a closed
// local map. Each that becomes settled, and still is there, is queued to be queried once against
// every other local map, and its own, as it is then: of two keyframes the one that settles later
// asks, so no pair is asked twice, and none is missed as long as workers keep up
// (QueryQueue::kMostOfLocalMap).
void SettleKeyframes(size_t settle_after, MissionState& state, LocalMapState& local_map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_SETTLING_H_
