// Counts what applying a batch costs beside its size: each new sight of a point counts that point
// for all pairs with the keyframes that see it already, and each new parent is looked for up to the
// root.
#ifndef CORBSLAM_MAP_STORE_INGEST_BATCH_COST_H_
#define CORBSLAM_MAP_STORE_INGEST_BATCH_COST_H_

#include <cstdint>

#include "absl/status/status.h"
#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// Returns about how many steps applying the batch to the local map (null: it is new) takes for
// pairs of keyframes and for parents: at most twice as many. Looks at the batch, and at what the
// removed keyframes see.
uint64_t CountPairSteps(const LocalMapState* local_map, const MapUpdateBatch& batch);

// Returns RESOURCE_EXHAUSTED if these are more than `max_pair_steps_per_batch`.
absl::Status ValidateCost(const LocalMapState* local_map, const MapUpdateBatch& batch,
                          const MapStoreOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_BATCH_COST_H_
