// How much an agent, and a mission, may store.
#ifndef CORBSLAM_MAP_STORE_INGEST_QUOTA_H_
#define CORBSLAM_MAP_STORE_INGEST_QUOTA_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "map_store/options.h"
#include "map_store/state/mission_state.h"
#include "slam/exchange/map_update.h"

namespace corbslam::map_store {

// Bytes of what a keyframe's camera saw.
uint64_t PayloadBytes(const KeyframePayload& payload);
// Bytes that a batch adds to what is kept of its local map, about. What is removed later is not
// taken off: it is remembered.
uint64_t StoredBytes(const MapUpdateBatch& batch);

// RESOURCE_EXHAUSTED, naming the agent or the mission and the limit, where the batch would be too
// much.
absl::Status CheckQuota(const MissionState& state, const std::string& agent,
                        const MapUpdateBatch& batch, const MapStoreOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_QUOTA_H_
