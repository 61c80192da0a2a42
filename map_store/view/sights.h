// Says what keyframes see, by names of the global layer.
#ifndef CORBSLAM_MAP_STORE_VIEW_SIGHTS_H_
#define CORBSLAM_MAP_STORE_VIEW_SIGHTS_H_

#include <cstdint>
#include <utility>
#include <vector>

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Returns what a keyframe of `local_map` sees: points of its island, its own and others', under the
// names that they go by now, without what fusion rejected.
Sights SightsOf(const MissionState& state, const LocalMapState& local_map,
                const Keyframe& keyframe);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_SIGHTS_H_
