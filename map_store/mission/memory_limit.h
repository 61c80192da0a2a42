// What a mission asks before it takes more memory.
#ifndef CORBSLAM_MAP_STORE_MISSION_MEMORY_LIMIT_H_
#define CORBSLAM_MAP_STORE_MISSION_MEMORY_LIMIT_H_

#include <cstdint>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace corbslam::map_store {

// All missions of a process share its memory. Thread-safe.
class MemoryLimit {
 public:
  virtual ~MemoryLimit() = default;

  // Returns RESOURCE_EXHAUSTED, with the memory in use and the limit, where `what` does not fit
  // with `bytes` more. It has room made first, which may take as long as writing a mission's
  // snapshot.
  virtual absl::Status Check(absl::string_view what, uint64_t bytes) = 0;
  // Does the same at once: who is refused comes again, and somebody else makes room meanwhile.
  virtual absl::Status CheckAtOnce(absl::string_view what, uint64_t bytes) = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_MEMORY_LIMIT_H_
