// The snapshots of one mission, by which the journal gets rid of older records.
#ifndef CORBSLAM_MAP_STORE_MISSION_MISSION_SNAPSHOTS_H_
#define CORBSLAM_MAP_STORE_MISSION_MISSION_SNAPSHOTS_H_

#include <functional>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "map_store/mission/mission_strand.h"

namespace corbslam::map_store {

// Thread-safe.
class MissionSnapshots {
 public:
  // Not owned; must outlive it.
  explicit MissionSnapshots(MissionStrand& strand) : strand_(strand) {}

  // Writes a snapshot into the journal, if it wants one. It is made from the journal itself, beside
  // the strand and the state's lock. CANCELLED once the mission is deleted or `goes_on`, called
  // often, says no.
  absl::Status Keep(const std::function<bool()>& goes_on) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns once none is being written.
  void WaitForEnd() ABSL_LOCKS_EXCLUDED(mutex_) { absl::MutexLock ended(&mutex_); }

 private:
  MissionStrand& strand_;
  absl::Mutex mutex_;  // Held from a snapshot's beginning to its end.
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_MISSION_SNAPSHOTS_H_
