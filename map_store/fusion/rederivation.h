// Makes the global layer again from what the owners say: when what was fused is not to be believed
// any more, or to compare two stores.
#ifndef CORBSLAM_MAP_STORE_FUSION_REDERIVATION_H_
#define CORBSLAM_MAP_STORE_FUSION_REDERIVATION_H_

#include <vector>

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Forgets all that fusion has found and made, but not what people took back. Each local map is an
// island again, and every settled keyframe waits to be looked up as it did when it settled, now in
// the order of local maps' and keyframes' ids.
void ForgetGlobalLayer(MissionState& state);

// Queues a query for every settled keyframe of a local map, to look it up in each of `against`.
void QueueAgain(const LocalMapState& asking, const std::vector<LocalMapId>& against,
                MissionState& state);

// Returns the island that the local map is by itself, of a newer generation than its present one.
Island MakeLoneIsland(const MissionState& state, LocalMapId id);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_REDERIVATION_H_
