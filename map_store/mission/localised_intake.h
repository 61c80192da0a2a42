// Takes what robots say that only localise: where they are now, and their trajectories.
#ifndef CORBSLAM_MAP_STORE_MISSION_LOCALISED_INTAKE_H_
#define CORBSLAM_MAP_STORE_MISSION_LOCALISED_INTAKE_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "map_store/mission/mission_strand.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// Takes what all such sessions of a mission say. Thread-safe.
class LocalisedIntake {
 public:
  // The argument is not owned and must outlive it.
  explicit LocalisedIntake(MissionStrand& strand) : strand_(strand) {}

  // Does what MapStore::NoteLocalised says.
  absl::StatusOr<std::optional<LocalisedKept>> Note(uint64_t session_id, const std::string& agent,
                                                    const LocalisedFrames& localised);

 private:
  // Returns PERMISSION_DENIED or ABORTED, with the reason.
  absl::Status Check(uint64_t session_id, const std::string& agent) const
      ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex());
  // Returns RESOURCE_EXHAUSTED, with the limit, if there is no room for the part.
  absl::Status CheckLimits(const LocalisedFrames& part) const;
  absl::Status NotePlace(uint64_t session_id, const std::string& agent,
                         const LocalisedFrames& localised);
  // Records the part if it is the next one of its run and there is room, and returns which is the
  // last. One that is there already needs no room.
  absl::StatusOr<LocalisedKept> Keep(uint64_t session_id, const std::string& agent,
                                     const LocalisedFrames& part);
  absl::StatusOr<LocalisedKept> KeepInTurn(uint64_t session_id, const std::string& agent,
                                           const LocalisedFrames& part);
  // Returns what there is of the run.
  absl::StatusOr<LocalisedKept> Last(uint64_t session_id, const std::string& agent,
                                     uint64_t run) const;
  // Logs the first of several failures, and the first success after it.
  void NoteOutcome(const absl::Status& kept);

  MissionStrand& strand_;
  absl::Mutex mutex_;
  bool fails_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_LOCALISED_INTAKE_H_
