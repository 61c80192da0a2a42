// The process's memory against a limit: robots are told to wait before the kernel ends it.
#ifndef CORBSLAM_MAP_STORE_MISSION_MEMORY_BUDGET_H_
#define CORBSLAM_MAP_STORE_MISSION_MEMORY_BUDGET_H_

#include <atomic>
#include <cstdint>
#include <functional>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace corbslam::map_store {

// Thread-safe. Everything counts, whoever allocated it: maps, what robots were told, the journal's
// buffers, views that workers are sent.
class MemoryBudget {
 public:
  // `limit_bytes` of the process; 0: none. `resident_bytes` measures, `clock` spaces what is done
  // to give memory back.
  MemoryBudget(uint64_t limit_bytes, std::function<uint64_t()> resident_bytes,
               std::function<absl::Time()> clock);

  // RESOURCE_EXHAUSTED, with what is there and the limit, where `what` does not fit with so many
  // bytes more.
  absl::Status Check(absl::string_view what, uint64_t bytes);

  uint64_t limit_bytes() const { return limit_bytes_; }
  // Checks that ended with an error.
  uint64_t refused() const { return refused_; }

 private:
  // Has the allocator give back what is free, unless that was done a moment ago.
  void Trim() ABSL_LOCKS_EXCLUDED(mutex_);

  const uint64_t limit_bytes_;
  const std::function<uint64_t()> resident_bytes_;
  const std::function<absl::Time()> clock_;
  std::atomic<uint64_t> refused_ = 0;
  absl::Mutex mutex_;
  absl::Time next_trim_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_MEMORY_BUDGET_H_
