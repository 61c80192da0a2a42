// Adds the flag that bounds a robot's memory (docs/robot.md).
#ifndef CORBSLAM_SERVICES_PROGRAMS_MEMORY_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_MEMORY_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>

#include "absl/status/status.h"
#include "services/programs/share_flags.h"

namespace corbslam::services {

struct MemoryFlags {
  // Bytes of the process; 0: no bound.
  uint64_t budget_bytes = 0;
};

// Bytes that a robot takes without a map: programs, vocabulary, pictures, threads' heaps.
constexpr uint64_t kRobotItself_bytes = uint64_t{160} << 20;
// With a smaller share for the map, local maps would be too short to be joined.
constexpr uint64_t kLeastForMap_bytes = uint64_t{64} << 20;

// Adds --memory-budget, which --help-all shows.
void AddMemoryFlags(CLI::App& app, MemoryFlags& flags);
// Returns INVALID_ARGUMENT for a budget that is too small, that has neither a map store nor a
// spool to go with, or that others' maps would break (--share everything). `outbox_bytes` is what
// may wait in memory.
absl::Status CheckMemoryFlags(const MemoryFlags& flags, const ShareFlags& share,
                              uint64_t outbox_bytes, bool has_keeper);
// Returns AgentOptions::max_map_bytes for a budget that was checked: half of what the robot itself
// and the outbox leave. The rest is for the old local map, which stays until it is told, and for a
// full adjustment of it, which takes as much again for a second or two. Without a map store it is
// one third: the robot itself reads whole local maps back, for a moment each, and keeps in memory
// what they look like.
uint64_t MaxMapBytes(const MemoryFlags& flags, uint64_t outbox_bytes, bool has_server = true);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_MEMORY_FLAGS_H_
