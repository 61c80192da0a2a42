// Makes of one mission's journal what takes a replay of it: snapshots, by which the journal gets
// rid of older records, backups, and the map's past.
#ifndef CORBSLAM_MAP_STORE_MISSION_MISSION_SNAPSHOTS_H_
#define CORBSLAM_MAP_STORE_MISSION_MISSION_SNAPSHOTS_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "map_store/archive/mission_archive.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/view/map_replay.h"

namespace corbslam::map_store {

// Makes one replay at a time. Thread-safe.
class MissionSnapshots {
 public:
  // `strand` is not owned and must outlive it.
  explicit MissionSnapshots(MissionStrand& strand) : strand_(strand) {}

  // Writes a snapshot into the journal, if the journal wants one; returns whether. It is made from
  // the journal itself, beside the strand and the state's lock. CANCELLED once the mission is
  // deleted or `goes_on`, which is called often, says no.
  absl::StatusOr<bool> Keep(const std::function<bool()>& goes_on) ABSL_LOCKS_EXCLUDED(mutex_);
  // Writes a snapshot, likewise made, that has what records don't say, unless nothing has changed
  // since the journal has it. Returns MissionStrand::changes as of then. ABORTED while another
  // replay is being made; FAILED_PRECONDITION if the journal has nothing of the mission.
  absl::StatusOr<uint64_t> KeepAll(const std::function<bool()>& goes_on)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns the mission as it is now, likewise made beside those who change it; where the journal
  // keeps nothing or is damaged, under the state's lock. CANCELLED once the mission is deleted.
  absl::StatusOr<MissionBackup> BackUp() ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns the map as it was when the journal begins, and what changed up to chosen revisions, up
  // to now; likewise made. Where the journal keeps nothing, it is the map as it is now.
  // RESOURCE_EXHAUSTED if that is too long, CANCELLED once `goes_on` says no, NOT_FOUND once the
  // mission is deleted.
  absl::StatusOr<std::vector<MapChanges>> TellPast(const ReplayOptions& options,
                                                   const std::function<bool()>& goes_on)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns once no snapshot is being written.
  void WaitForEnd() ABSL_LOCKS_EXCLUDED(mutex_) { absl::MutexLock ended(&mutex_); }

 private:
  // What a replay reads of the mission itself: the rest is read from the journal.
  struct Beginning;

  // The caller holds the writers' turn: no record comes between the state and its position.
  Beginning Begin() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(strand_.turn());
  // Returns the state, without features, as it was at the beginning, whose position is then that of
  // the last record that there was.
  absl::StatusOr<MissionState> Replay(Beginning& beginning, const std::function<bool()>& goes_on,
                                      const StateVisitor& visit = nullptr) const;
  absl::Status CheckMemory(uint64_t bytes) const;
  absl::StatusOr<uint64_t> KeepAllLocked(const std::function<bool()>& goes_on)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status Write(Beginning& beginning, const std::function<bool()>& goes_on)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  MissionStrand& strand_;
  // Held from a replay's beginning to its end: a snapshot that was written meanwhile would take the
  // place of records that the replay reads.
  absl::Mutex mutex_;
  // The changes that the journal has, those included that records don't say.
  uint64_t kept_changes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_MISSION_SNAPSHOTS_H_
