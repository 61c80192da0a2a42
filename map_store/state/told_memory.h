// Says how much memory it takes to know what the agents of a mission were told.
#ifndef CORBSLAM_MAP_STORE_STATE_TOLD_MEMORY_H_
#define CORBSLAM_MAP_STORE_STATE_TOLD_MEMORY_H_

#include <cstdint>
#include <map>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace corbslam::map_store {

// Bytes by agent, about. It is thread-safe: whoever reads a mission's state and tells an agent of
// it says so here. A copy begins empty: nobody was told anything of it.
class ToldMemory {
 public:
  ToldMemory() = default;
  ToldMemory(const ToldMemory&) {}
  ToldMemory(ToldMemory&&) noexcept {}
  ToldMemory& operator=(const ToldMemory&) { return *this; }
  ToldMemory& operator=(ToldMemory&&) noexcept { return *this; }
  ~ToldMemory() = default;

  void Set(const std::string& agent, uint64_t bytes) const {
    absl::MutexLock lock(&mutex_);
    uint64_t& of_agent = bytes_[agent];
    all_ += bytes - of_agent;
    of_agent = bytes;
  }
  uint64_t all() const {
    absl::MutexLock lock(&mutex_);
    return all_;
  }

 private:
  mutable absl::Mutex mutex_;
  mutable std::map<std::string, uint64_t> bytes_ ABSL_GUARDED_BY(mutex_);
  mutable uint64_t all_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_TOLD_MEMORY_H_
