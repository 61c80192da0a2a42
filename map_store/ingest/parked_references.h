// Parks references of a local map to its own items that have not arrived: they wait, within a bound
// in number (which validation keeps) and in time.
#ifndef CORBSLAM_MAP_STORE_INGEST_PARKED_REFERENCES_H_
#define CORBSLAM_MAP_STORE_INGEST_PARKED_REFERENCES_H_

#include "absl/time/time.h"
#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Applies an observation or a loop edge, or lets it wait for what it refers to.
void TakeReference(const ParkedReference& reference, MissionState& state, LocalMapState& local_map);

// Hangs the child on its parent, or lets it wait for the parent. An older word about the child's
// parent that still waits counts no more.
void TakeParent(KeyframeId child, KeyframeId parent, LocalMapState& local_map);

// Applies what waited for an item that came, or that is known never to come.
void RetryParked(MissionState& state, LocalMapState& local_map);

// Forgets what has waited for longer than `max_parked_s`, and counts it in `expired_references`.
void ExpireParked(absl::Time now, const MapStoreOptions& options, LocalMapState& local_map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_PARKED_REFERENCES_H_
