// The changes of one local map's graph, with one function for each kind. Each takes the state of
// the mission, because landmarks and the global layer follow what owners replace and remove.
#ifndef CORBSLAM_MAP_STORE_INGEST_GRAPH_CHANGES_H_
#define CORBSLAM_MAP_STORE_INGEST_GRAPH_CHANGES_H_

#include <optional>

#include "map_store/state/mission_state.h"
#include "slam/exchange/map_update.h"

namespace corbslam::map_store {

// These return the item that the change refers to and that has not arrived, so that the change is
// to be parked. A change that refers to removed items is dropped, and does not wait. The owner's
// latest word wins over its earlier ones.
std::optional<MissingItem> ApplyObservation(const ObservationChange& change, MissionState& state,
                                            LocalMapState& local_map);
std::optional<MissingItem> ApplyParent(KeyframeId child, KeyframeId parent,
                                       LocalMapState& local_map);
std::optional<MissingItem> ApplyLoopEdge(const LoopEdge& edge, MissionState& state,
                                         LocalMapState& local_map);

void ApplyReplacement(const PointReplacement& replacement, MissionState& state,
                      LocalMapState& local_map);
void ApplyPointRemoval(MapPointId point, MissionState& state, LocalMapState& local_map);
void ApplyKeyframeRemoval(const KeyframeRemoval& removal, MissionState& state,
                          LocalMapState& local_map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_GRAPH_CHANGES_H_
