// Tells an agent whose local map is alone where it lies in the mission's global frame.
#ifndef CORBSLAM_MAP_STORE_SHARING_GLOBAL_PLACE_H_
#define CORBSLAM_MAP_STORE_SHARING_GLOBAL_PLACE_H_

#include <optional>

#include "map_store/state/mission_state.h"
#include "map_store/state/share_state.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::map_store {

// Returns global_from_local of a local map in the reference island that has a keyframe, by the
// newest of those that fusion has placed, or as a whole; nullopt for any other local map, whose
// place in the global frame nobody knows.
std::optional<Similarity3d> FindGlobalPlace(const MissionState& state,
                                            const LocalMapState& local_map);

// Returns the same for the agent's own local map if it was not told that already, and notes it in
// `share` as told. What the owner adjusts does not change it.
std::optional<Similarity3d> TakeGlobalPlace(const MissionState& state, ShareState& share);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_SHARING_GLOBAL_PLACE_H_
