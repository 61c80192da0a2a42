// Says where lengths are in metres: maps of one camera alone are in a unit of their own.
#ifndef CORBSLAM_MAP_STORE_VIEW_METRES_H_
#define CORBSLAM_MAP_STORE_VIEW_METRES_H_

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Returns whether all cameras of the local map measure depths; false before it has any.
bool IsInMetres(const LocalMapState& local_map);

// Returns whether lengths in the island's frame are metres: one of its local maps has them, and an
// island that has them keeps its frame in every merge with one that has not (fusion_policy.h).
bool IsInMetres(const MissionState& state, const Island& island);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_METRES_H_
