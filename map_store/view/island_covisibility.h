// Counts how much each two keyframes of an island see together.
#ifndef CORBSLAM_MAP_STORE_VIEW_ISLAND_COVISIBILITY_H_
#define CORBSLAM_MAP_STORE_VIEW_ISLAND_COVISIBILITY_H_

#include <vector>

#include "absl/status/statusor.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/long_read.h"

namespace corbslam::map_store {

struct CovisiblePair {
  KeyframeId a;  // Less than `b`.
  KeyframeId b;
  int weight = 0;  // Landmarks that both see, as far as owners and fusion know.
};

// Returns what owners counted inside their local maps, with what fusion and foreign observations
// add to it, in ascending order. The cost grows with the landmarks that more than one local map, or
// point, takes part in; there are sixteen bytes for each two keyframes that see something together.
// Returns ABORTED as `read` does.
absl::StatusOr<std::vector<CovisiblePair>> CountCovisibility(const MissionState& state,
                                                             const Island& island, LongRead& read);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_ISLAND_COVISIBILITY_H_
