// Makes the snapshots of one mission, by which the journal gets rid of older records.
#ifndef CORBSLAM_MAP_STORE_MISSION_MISSION_SNAPSHOTS_H_
#define CORBSLAM_MAP_STORE_MISSION_MISSION_SNAPSHOTS_H_

#include <functional>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "map_store/archive/mission_archive.h"
#include "map_store/mission/mission_strand.h"

namespace corbslam::map_store {

// Makes one snapshot or backup at a time. Thread-safe.
class MissionSnapshots {
 public:
  // `strand` is not owned and must outlive it.
  explicit MissionSnapshots(MissionStrand& strand) : strand_(strand) {}

  // Writes a snapshot into the journal, if the journal wants one. It is made from the journal
  // itself, beside the strand and the state's lock. CANCELLED once the mission is deleted or
  // `goes_on`, which is called often, says no.
  absl::Status Keep(const std::function<bool()>& goes_on) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns the mission as it is now, likewise made beside those who change it; where the journal
  // keeps nothing, under the state's lock. CANCELLED once the mission is deleted.
  absl::StatusOr<MissionBackup> BackUp() ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns once no snapshot is being written.
  void WaitForEnd() ABSL_LOCKS_EXCLUDED(mutex_) { absl::MutexLock ended(&mutex_); }

 private:
  // What a snapshot reads of the mission itself: the rest is read from the journal.
  struct Beginning;

  // The caller holds the writers' turn: no record comes between the state and its position.
  Beginning Begin() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());
  // Returns the state, without features, as it was at the beginning.
  absl::StatusOr<MissionState> Replay(Beginning beginning,
                                      const std::function<bool()>& goes_on) const;

  MissionStrand& strand_;
  // Held from a snapshot's beginning to its end.
  absl::Mutex mutex_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_MISSION_SNAPSHOTS_H_
