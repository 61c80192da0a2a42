// Limits how much an agent, and a mission, may store.
#ifndef CORBSLAM_MAP_STORE_INGEST_QUOTA_H_
#define CORBSLAM_MAP_STORE_INGEST_QUOTA_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// Returns the bytes of what a keyframe's camera saw.
uint64_t PayloadBytes(const KeyframePayload& payload);
// Returns about how many bytes a batch adds to what is kept of its local map. What is removed later
// is not subtracted: it is remembered.
uint64_t StoredBytes(const MapUpdateBatch& batch);
// Returns about how many bytes a part of a trajectory adds to what is kept of its agent.
uint64_t StoredBytes(const LocalisedFrames& part);

// Returns RESOURCE_EXHAUSTED, naming the agent or the mission and the limit, if the batch would be
// too much.
absl::Status CheckQuota(const MissionState& state, const std::string& agent,
                        const MapUpdateBatch& batch, const MapStoreOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_QUOTA_H_
