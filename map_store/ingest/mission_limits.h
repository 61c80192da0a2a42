// Holds batches against the limits that people set of one mission and its agents
// (MissionProfile::limits). The store's own limits are in quota.h.
#ifndef CORBSLAM_MAP_STORE_INGEST_MISSION_LIMITS_H_
#define CORBSLAM_MAP_STORE_INGEST_MISSION_LIMITS_H_

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// All functions return RESOURCE_EXHAUSTED with whose limit it is, its name and value, and what is
// there, if the batch would be too much.

// Returns "batch 7 of local map 00ab...", or "part 7 of run 00ab...".
std::string NameOfBatch(const MapUpdateBatch& batch);
std::string NameOfPart(const LocalisedFrames& part);

// Checks the numbers of keyframes of the mission and of the agent. A batch without new keyframes
// always passes: poses, removals and the end of a local map.
absl::Status CheckKeyframeLimits(const MissionState& state, const std::string& agent,
                                 const MapUpdateBatch& batch);
// Checks the mission's memory, as EstimateMemory tells it. A batch without full keyframes and
// points always passes.
absl::Status CheckMemoryLimit(const MissionState& state, const MapUpdateBatch& batch);
// Likewise of an agent that only localises: a part without poses always passes.
absl::Status CheckMemoryLimit(const MissionState& state, const LocalisedFrames& part);
// Checks what the mission takes of the journal's disk, `disk_bytes`; `what` wants so many more.
absl::Status CheckDiskLimit(const std::string& mission, uint64_t disk_bytes, uint64_t limit_bytes,
                            const std::string& what, uint64_t bytes);

// No mission has more local maps, whatever their state: messages about an island name its local
// maps in a table that has no more places (services/convert/limits.h).
inline constexpr size_t kMaxLocalMapsInAll = 10'000;

// Returns how many local maps count against the options' limit. Those that their owners closed and
// fusion has joined with others are done with: robots that start often would else fill a mission.
size_t CountLimitedLocalMaps(const MissionState& state);
// Checks whether the mission takes another local map.
absl::Status CheckRoomForLocalMap(const MissionState& state, const MapStoreOptions& options);
// Checks whether it has no more than may be.
absl::Status CheckLocalMaps(const MissionState& state, const MapStoreOptions& options);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_INGEST_MISSION_LIMITS_H_
