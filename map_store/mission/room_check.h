// Checks that there is room for what comes to a mission.
#ifndef CORBSLAM_MAP_STORE_MISSION_ROOM_CHECK_H_
#define CORBSLAM_MAP_STORE_MISSION_ROOM_CHECK_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "map_store/mission/mission_strand.h"

namespace corbslam::map_store {

// RESOURCE_EXHAUSTED names `what` comes, and the limit: the store's memory for so many bytes, or
// the mission's limits.disk_bytes for so many. Takes the state's lock.
absl::Status CheckRoom(const MissionStrand& strand, const std::string& what, uint64_t memory_bytes,
                       uint64_t disk_bytes);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_ROOM_CHECK_H_
