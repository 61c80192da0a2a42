// Estimates what a robot's map takes in memory.
#ifndef CORBSLAM_CLIENT_AGENT_MAP_MAP_BYTES_H_
#define CORBSLAM_CLIENT_AGENT_MAP_MAP_BYTES_H_

#include <cstdint>

#include "slam/map/map.h"

namespace corbslam::client_agent {

// Returns about how many bytes of the process the map's items take, own and others' alike, with
// what is held beside the map for each: places by their words, what the map store was told of own
// items, what it said of others'. The number of items alone decides, so that it costs as much as
// there are keyframes. What an item takes was counted; how near that comes to what the process
// takes is not measured yet (docs/lab/2026-11-27-bounded-robot.md).
uint64_t EstimateBytes(const Map& map);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAP_MAP_BYTES_H_
