// What keyframes see, in the words of the global layer.
#ifndef CORBSLAM_MAP_STORE_VIEW_SIGHTS_H_
#define CORBSLAM_MAP_STORE_VIEW_SIGHTS_H_

#include <cstdint>
#include <utility>
#include <vector>

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Of a keyframe of `local_map`: its own and others' points of its island under the names that they
// go by now, without what fusion rejected.
Sights SightsOf(const MissionState& state, const LocalMapState& local_map,
                const Keyframe& keyframe);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_SIGHTS_H_
