// Chooses which local maps become one.
#ifndef CORBSLAM_MAP_STORE_JOINING_JOINING_CHOICE_H_
#define CORBSLAM_MAP_STORE_JOINING_JOINING_CHOICE_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>

#include "map_store/joining/local_map_joining.h"

namespace corbslam::map_store {

// What earlier choices found of local maps that are there still. Is a value.
struct JoiningMemory {
  // Whether the local map's keyframes stand by themselves, as of a revision and with so many.
  struct Trees {
    uint64_t revision = 0;
    size_t keyframes = 0;
    bool stand = false;
  };
  std::map<LocalMapId, Trees> trees;
  uint64_t walked = 0;  // How many local maps' trees were walked so far.
};

// Returns the next joining: the earliest local map of an agent that becomes a part of an earlier
// one of the same island. The newest `kept` closed ones of each agent stay as they are, since
// overlaps that join these can still be taken back. Local maps with units of their own (single
// cameras) stay, too. Costs a look at each local map, and a walk through the trees of two for each
// that has another to join; what `memory` knows is not walked again until it may have changed.
std::optional<LocalMapJoining> ChooseJoining(const MissionState& state, size_t kept,
                                             JoiningMemory& memory);
// Without a memory.
std::optional<LocalMapJoining> ChooseJoining(const MissionState& state, size_t kept);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_JOINING_JOINING_CHOICE_H_
