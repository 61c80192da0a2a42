// Says about how much memory a mission's map takes.
#ifndef CORBSLAM_MAP_STORE_VIEW_MEMORY_ESTIMATE_H_
#define CORBSLAM_MAP_STORE_VIEW_MEMORY_ESTIMATE_H_

#include <cstdint>

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Returns bytes. It looks at a few keyframes of each local map and multiplies, so that it may be
// asked for every few seconds.
uint64_t EstimateMemory(const MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_MEMORY_ESTIMATE_H_
