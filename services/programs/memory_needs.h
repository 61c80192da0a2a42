// Divides a robot's --memory-budget among what it is for (docs/robot.md).
#ifndef CORBSLAM_SERVICES_PROGRAMS_MEMORY_NEEDS_H_
#define CORBSLAM_SERVICES_PROGRAMS_MEMORY_NEEDS_H_

#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

// What a robot's memory depends on, beside its map.
struct MemoryNeeds {
  int features = 2000;  // Of a picture.
  // Of each of the camera's pictures; 0: not known yet, and they may be small.
  int width_px = 0;
  int height_px = 0;
  // What may wait in memory for the map store.
  uint64_t outbox_bytes = 0;
};

// Returns the bytes that a robot takes without a map: programs, vocabulary, threads' heaps, and
// what it works with for pictures of that size.
uint64_t RobotItselfBytes(const MemoryNeeds& needs);
// Returns the least bytes for its maps: with less, local maps would be too short to be joined.
uint64_t LeastBytesForMap(const MemoryNeeds& needs);
// Returns how much the outbox takes of a budget unless somebody says it: an eighth, 64 MiB at most.
uint64_t OutboxBytesOf(uint64_t budget_bytes);

// Returns INVALID_ARGUMENT for a budget that is too small, that has neither a map store nor a
// spool to go with, or that others' maps would break (--share everything, if that was said). 0 is
// no budget, and good.
absl::Status CheckMemoryBudget(uint64_t budget_bytes, std::optional<ShareMode> share,
                               const MemoryNeeds& needs, bool has_keeper);
// Returns AgentOptions::max_map_bytes for a budget that was checked: half of what the robot itself
// and the outbox leave. The rest is for the old local map, which stays until it is told, and for a
// full adjustment of it, which takes as much again for a second or two. Without a map store it is
// one third: the robot itself reads whole local maps back, for a moment each, and keeps in memory
// what they look like.
uint64_t MaxMapBytes(uint64_t budget_bytes, const MemoryNeeds& needs, bool has_server = true);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_MEMORY_NEEDS_H_
