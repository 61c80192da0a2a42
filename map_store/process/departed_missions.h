// Remembers missions that were deleted, so that no robot of one makes it anew.
#ifndef CORBSLAM_MAP_STORE_PROCESS_DEPARTED_MISSIONS_H_
#define CORBSLAM_MAP_STORE_PROCESS_DEPARTED_MISSIONS_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "map_store/records/journal.h"

namespace corbslam::map_store {

// Remembers the last ones, the oldest of which it forgets. Thread-safe.
class DepartedMissions {
 public:
  // Of so many missions the uids are remembered, as many as a journal keeps, ...
  static constexpr size_t kMaxMissions = Journal::kMaxListed;
  // ... and of so many agents their processes.
  static constexpr size_t kMaxProcesses = 100'000;
  // SessionRequest::instance by the agent's name.
  using Processes = std::map<std::string, uint64_t>;

  // An empty uid: nobody knows it, and it is taken for any.
  void Note(MissionIdentity mission, Processes processes) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns whether a mission of this name and uid was deleted.
  bool Has(absl::string_view name, absl::string_view uid) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns whether this process of the agent was in a mission of this name that was deleted, and
  // is not the one with the uid `present`.
  bool HasProcess(absl::string_view name, absl::string_view present, const std::string& agent,
                  uint64_t instance) const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Departed {
    MissionIdentity mission;
    Processes processes;
  };

  mutable absl::Mutex mutex_;
  std::deque<Departed> departed_ ABSL_GUARDED_BY(mutex_);
  // The number of all processes, and the first entry that may have any.
  size_t processes_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t first_with_processes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_DEPARTED_MISSIONS_H_
