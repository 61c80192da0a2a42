// Takes a valid batch over into the local layer.
#ifndef CORBSLAM_MAP_STORE_INGEST_BATCH_APPLICATION_H_
#define CORBSLAM_MAP_STORE_INGEST_BATCH_APPLICATION_H_

#include <map>
#include <memory>
#include <vector>

#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"
#include "slam/exchange/map_update.h"

namespace corbslam::map_store {

// Words of the batch's full keyframes. They are computed without any lock held.
using BatchWords = std::map<KeyframeId, std::shared_ptr<const Words>>;

// Returns the batch without full keyframes that `local_map` (null: a new one) had before: they
// would change nothing, and must not take the place of what the journal has of them. If there are
// none, the result is not a copy and must not outlive `batch`.
std::shared_ptr<const MapUpdateBatch> WithoutKnownKeyframes(const MapUpdateBatch& batch,
                                                            const LocalMapState* local_map);

// Applies the batch in the order of its fields; it must be valid, and the next one of `local_map`.
// Besides the local layer this changes landmarks whose members the owner replaced or removed,
// settles keyframes (which become queries), and notes what an owner's motion means for placed
// keyframes. What is known already is not applied again; ids of removed items never come back.
void ApplyBatch(const MapUpdateBatch& batch, const BatchWords& words,
                const MapStoreOptions& options, MissionState& state, LocalMapState& local_map);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_BATCH_APPLICATION_H_
