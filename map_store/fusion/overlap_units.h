// Between the units in which overlaps are kept and those in which workers see them.
#ifndef CORBSLAM_MAP_STORE_FUSION_OVERLAP_UNITS_H_
#define CORBSLAM_MAP_STORE_FUSION_OVERLAP_UNITS_H_

#include "map_store/state/mission_state.h"
#include "slam/exchange/overlap.h"

namespace corbslam::map_store {

// An overlap that is kept says how cameras stand to each other in the units of their owners' local
// maps, which no merge changes. Workers are shown islands, and what they find and are told is in
// the units of these. Both are metres wherever cameras measure depths. Keyframes that the state
// does not have leave the overlap as it is.
void ToOwnersUnits(const MissionState& state, Overlap& overlap);
void ToIslandsUnits(const MissionState& state, Overlap& overlap);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_OVERLAP_UNITS_H_
