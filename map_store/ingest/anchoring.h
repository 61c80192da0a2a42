// Keeps the points that fusion placed anchored in placed keyframes (PlacedPoint) while owners
// remove keyframes and points stand for others.
#ifndef CORBSLAM_MAP_STORE_INGEST_ANCHORING_H_
#define CORBSLAM_MAP_STORE_INGEST_ANCHORING_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// A point that loses its anchor, where it lies, and the revision that put it there.
struct LostPlace {
  MapPointId id;
  Eigen::Vector3d position_in_island;
  uint64_t revision = 0;
};

// Takes the places of the points that are anchored in a keyframe of `local_map`, which is about to
// be removed.
std::vector<LostPlace> TakePlaces(KeyframeId id, GlobalLayer& global, LocalMapState& local_map);
// Anchors the points in other keyframes. Where no placed one sees a point, the point is not placed
// any more.
void AnchorElsewhere(const std::vector<LostPlace>& lost, MissionState& state);

// Hands the place of `from` over to the point that stands for it now, if that has none of its own.
// An invalid `to`: the place goes.
void HandOverPlace(MapPointId from, MapPointId to, MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_ANCHORING_H_
