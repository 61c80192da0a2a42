// Holds the process's memory against a limit: robots are told to wait before the kernel ends the
// process.
#ifndef CORBSLAM_MAP_STORE_PROCESS_MEMORY_BUDGET_H_
#define CORBSLAM_MAP_STORE_PROCESS_MEMORY_BUDGET_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/mission/memory_limit.h"

namespace corbslam::map_store {

// Checks the memory of the whole process, whoever allocated it: maps, what robots were told, the
// journal's buffers, views that workers are sent. Thread-safe.
class MemoryBudget : public MemoryLimit {
 public:
  // `limit_bytes` is of the process; 0: there is no limit. `resident_bytes` measures the process,
  // and `clock` says when it is time again to give memory back. `used_bytes`, where there is one,
  // leaves out what the allocator keeps for itself; it may take a while, and is asked only where
  // the process is larger than it should be.
  MemoryBudget(uint64_t limit_bytes, std::function<uint64_t()> resident_bytes,
               std::function<absl::Time()> clock, std::function<uint64_t()> used_bytes = nullptr);

  // Gives memory back that can be had again, and returns whether that is so; nobody calls it while
  // it runs. Called before all else.
  void SetRoomMaker(std::function<bool()> make_room) { make_room_ = std::move(make_room); }

  absl::Status Check(absl::string_view what, uint64_t bytes) override;
  absl::Status CheckAtOnce(absl::string_view what, uint64_t bytes) override;

  uint64_t limit_bytes() const { return limit_bytes_; }
  // Returns whether so little is left that it is time to make room, before anything is refused.
  bool IsShort() const;
  // Returns whether somebody was refused by CheckAtOnce since the last call.
  bool TakeWanted() { return wanted_.exchange(false); }
  // Returns the number of checks that ended with an error.
  uint64_t refused() const { return refused_; }

 private:
  bool Fits(uint64_t bytes) const;
  // Returns what counts of the process's memory.
  uint64_t Counted() const;
  absl::Status Refuse(absl::string_view what, uint64_t bytes);
  // Makes room until `bytes` fit; returns whether they do.
  bool MakeRoomFor(uint64_t bytes) ABSL_LOCKS_EXCLUDED(making_room_);
  // Has the allocator give back what is free, unless that was done a moment ago.
  void Trim() ABSL_LOCKS_EXCLUDED(mutex_);

  const uint64_t limit_bytes_;
  const std::function<uint64_t()> resident_bytes_;
  const std::function<absl::Time()> clock_;
  const std::function<uint64_t()> used_bytes_;
  std::function<bool()> make_room_;
  std::atomic<bool> wanted_ = false;
  std::atomic<uint64_t> refused_ = 0;
  absl::Mutex making_room_;
  absl::Mutex mutex_;
  absl::Time next_trim_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_MEMORY_BUDGET_H_
