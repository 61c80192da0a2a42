// Finds what holds local maps together that contradict each other in size.
#ifndef CORBSLAM_MAP_STORE_COORDINATION_SCALE_CONTRADICTIONS_H_
#define CORBSLAM_MAP_STORE_COORDINATION_SCALE_CONTRADICTIONS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "map_store/state/mission_state.h"
#include "slam/exchange/agent_report.h"

namespace corbslam::map_store {

// Beyond this two local maps can't be one map: over a hundred metres they part by a metre.
// What differs by less is fused, as it was measured (docs/adr/0042-others-distances.md).
inline constexpr double kToleratedScale = 0.01;

struct ContradictedOverlap {
  uint64_t overlap = 0;
  LocalMapId own;
  LocalMapId others;
  double scale = 1;
};

// Returns a live overlap between each local map that the agent is making and each other one that it
// says differs by more than is tolerated; none where nothing links the two. The others between the
// same two go with it (RetractRecord::keep_apart).
std::vector<ContradictedOverlap> FindContradicted(
    const MissionState& state, const std::string& agent,
    const std::vector<MapContradiction>& contradictions);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_COORDINATION_SCALE_CONTRADICTIONS_H_
