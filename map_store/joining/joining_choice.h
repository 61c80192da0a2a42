// Chooses which local maps become one.
#ifndef CORBSLAM_MAP_STORE_JOINING_JOINING_CHOICE_H_
#define CORBSLAM_MAP_STORE_JOINING_JOINING_CHOICE_H_

#include <cstddef>
#include <optional>

#include "map_store/joining/local_map_joining.h"

namespace corbslam::map_store {

// Returns the next joining: the earliest local map of an agent that becomes a part of an earlier
// one of the same island. The newest `kept` closed ones of each agent stay as they are, since
// overlaps that join these can still be taken back. Local maps with units of their own (single
// cameras) stay, too. Costs a look at each local map.
std::optional<LocalMapJoining> ChooseJoining(const MissionState& state, size_t kept);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_JOINING_JOINING_CHOICE_H_
