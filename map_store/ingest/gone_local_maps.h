// Says which local maps take no batches any more, whatever their robots say.
#ifndef CORBSLAM_MAP_STORE_INGEST_GONE_LOCAL_MAPS_H_
#define CORBSLAM_MAP_STORE_INGEST_GONE_LOCAL_MAPS_H_

#include "absl/status/status.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Returns FAILED_PRECONDITION for a local map that has become a part of another one, of which
// others have become parts, or that was deleted: a robot that comes back to it begins a new one.
// What it sent before is acknowledged as ever (LastBatchOf).
absl::Status CheckTakesBatches(const MissionState& state, LocalMapId local_map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_GONE_LOCAL_MAPS_H_
