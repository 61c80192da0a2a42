// Lets go of what a mission can do without while nothing is fused of it. Queries may wait, and who
// fuses for a minute is waited for no longer: a worker that is short of time must not keep known
// ground.
#ifndef CORBSLAM_MAP_STORE_COORDINATION_MISSION_RETIRING_H_
#define CORBSLAM_MAP_STORE_COORDINATION_MISSION_RETIRING_H_

#include <functional>
#include <optional>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/coordination/fusion_coordinator.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/records/journal_records.h"
#include "map_store/retiring/retiring_pass.h"

namespace corbslam::map_store {

// Looks at one stretch after the other of what is closed and joined. Thread-safe.
class MissionRetiring {
 public:
  // None of them is owned; all must outlive it. `notify` is called, without locks, when something
  // that others see has gone.
  MissionRetiring(MissionStrand& strand, const FusionCoordinator& fusion,
                  std::function<void()> notify)
      : strand_(strand), fusion_(fusion), notify_(std::move(notify)) {}

  // Looks at the next stretch, if fusion rests but for queries or has not rested for a minute (in
  // lockstep: if it rests), and lets go of what it finds.
  // Returns whether there was one, and it is done with. Another thread's turn, a state that changed
  // meanwhile and a journal that takes nothing leave it for later.
  bool RunOne();
  // Returns whether something is still to be looked at.
  bool IsDue() const;
  // Returns whether everything was looked at: not where nothing retires, or there is no worker.
  bool IsDone() const { return IsWanted() && !IsDue(); }
  // The caller says that it was when the mission fell asleep, and that its state is as it was then.
  void NoteAllDone();

 private:
  struct Taken {
    RetiringStretch stretch;
    RetiringView view;
  };

  // Returns whether a stretch that is due may be looked at.
  bool MayBegin();
  bool IsWanted() const { return strand_.options().retire && strand_.environment().has_worker; }
  // Returns ABORTED if there is nothing to look at, or fusion has begun something.
  absl::StatusOr<Taken> TakeNext() ABSL_EXCLUSIVE_LOCKS_REQUIRED(turn_);
  // Returns false where it is to be tried later.
  bool Commit(const Taken& taken, const Retirement& retirement)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(turn_);
  bool CommitPart(const RetiringView& view, const RetireRecord& record)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(turn_);

  MissionStrand& strand_;
  const FusionCoordinator& fusion_;
  const std::function<void()> notify_;
  absl::Mutex turn_;  // Whoever looks at a stretch holds it.
  absl::Mutex patience_mutex_;
  // When a stretch was due for the first time since fusion rested last, or nothing was due.
  std::optional<absl::Time> waits_since_ ABSL_GUARDED_BY(patience_mutex_);
  RetiringPasses passes_ ABSL_GUARDED_BY(strand_.mutex());
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_COORDINATION_MISSION_RETIRING_H_
