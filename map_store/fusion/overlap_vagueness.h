// How well an overlap says where one local map is to another.
#ifndef CORBSLAM_MAP_STORE_FUSION_OVERLAP_VAGUENESS_H_
#define CORBSLAM_MAP_STORE_FUSION_OVERLAP_VAGUENESS_H_

#include "slam/exchange/overlap.h"
#include "slam/map/map.h"

namespace corbslam::map_store {

// True if the overlap leaves either camera uncertain by more than a hundredth of the distance of
// what the candidate sees: others' points are some pixels beside their place for whoever was put
// into their map by it (docs/adr/0052-vague-overlaps-wait.md). `map` has the candidate and its
// points. False where the covariance is not known, or these have gone.
bool IsVague(const Overlap& overlap, const Map& map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_OVERLAP_VAGUENESS_H_
