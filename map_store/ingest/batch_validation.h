// Checks that a batch is fit to be applied. All that comes from an agent is looked at here, before
// anything is changed.
#ifndef CORBSLAM_MAP_STORE_INGEST_BATCH_VALIDATION_H_
#define CORBSLAM_MAP_STORE_INGEST_BATCH_VALIDATION_H_

#include <string>

#include "absl/status/status.h"
#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// Checks the name of a mission or an agent, which is 1 to 128 of [a-zA-Z0-9._-].
absl::Status ValidateName(const std::string& what, const std::string& name);

// Checks a batch; `local_map` is null if the batch opens it. Returns INVALID_ARGUMENT for values
// that mean nothing, PERMISSION_DENIED for what is not the local map's own, and RESOURCE_EXHAUSTED
// for too much of it; each names the id, the value and the limit. References to what is not there
// are no errors.
absl::Status ValidateBatch(const LocalMapState* local_map, const MapUpdateBatch& batch,
                           const MapStoreOptions& options);

// Checks a batch that a store has taken in before, with other limits or none, and when a batch
// could still name a light item more than once.
absl::Status ValidateRecordedBatch(const LocalMapState* local_map, const MapUpdateBatch& batch);

// Checks a part of a trajectory (LocalisedFrames::run). INVALID_ARGUMENT for values that mean
// nothing.
absl::Status ValidateLocalised(const LocalisedFrames& part);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_BATCH_VALIDATION_H_
