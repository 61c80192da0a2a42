#include "map_store/mission/room_check.h"

#include "map_store/ingest/mission_limits.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

absl::Status CheckRoom(const MissionStrand& strand, const std::string& what, uint64_t memory_bytes,
                       uint64_t disk_bytes) {
  RETURN_IF_ERROR(strand.environment().memory->CheckAtOnce(what, memory_bytes));
  const uint64_t limit =
      strand.WithState([](const MissionState& state) { return state.profile.limits.disk_bytes; });
  // Finding out what is there reads the mission's folder.
  if (limit == 0) return absl::OkStatus();
  const uint64_t there = strand.environment().journal->DiskBytes(strand.name());
  return CheckDiskLimit(strand.name(), there, limit, what, disk_bytes);
}

}  // namespace corbslam::map_store
