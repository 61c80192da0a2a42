#include "map_store/coordination/mission_retiring.h"

#include <glog/logging.h>

#include <optional>
#include <utility>

#include "map_store/mission/pausing_read.h"
#include "map_store/records/record_application.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Where keyframes have been adjusted to each other, what stands in for another lies beside it as
// well as it can; a worker that stands still is worse than a stand-in that is off by millimetres.
constexpr absl::Duration kPatience = absl::Minutes(1);

}  // namespace

bool MissionRetiring::IsDue() const {
  if (!IsWanted() || strand_.IsDamaged()) return false;
  absl::ReaderMutexLock lock(&strand_.mutex());
  return !strand_.deleted() && passes_.IsDue(strand_.state());
}

void MissionRetiring::NoteAllDone() {
  StateWriteLock lock(strand_);
  passes_.NoteAllDone(strand_.state());
}

bool MissionRetiring::MayBegin() {
  const bool is_due = IsDue();
  const bool rests = !is_due || fusion_.RestsButForQueries();
  absl::MutexLock lock(&patience_mutex_);
  if (rests) {
    waits_since_.reset();
    return is_due;
  }
  const absl::Time now = strand_.environment().clock();
  if (!waits_since_.has_value() || now < *waits_since_) waits_since_ = now;
  return !strand_.options().deterministic && now - *waits_since_ >= kPatience;
}

bool MissionRetiring::RunOne() {
  if (!MayBegin() || !turn_.TryLock()) return false;
  bool done = false;
  Retirement retirement;
  const absl::StatusOr<Taken> taken = TakeNext();
  if (taken.ok()) {
    StayCounts stays;
    retirement = PlanRetirement(taken->view, strand_.options(), VLOG_IS_ON(1) ? &stays : nullptr);
    VLOG(1) << "mission " << strand_.name() << ": of " << taken->view.candidates.size()
            << " keyframes stay " << ToString(stays);
    done = Commit(*taken, retirement);
  }
  turn_.Unlock();
  if (!retirement.empty()) {
    LOG(INFO) << "mission " << strand_.name() << ": " << retirement.keyframes.size()
              << " keyframes retire, " << retirement.faded.size() << " points fade";
    notify_();
  }
  return done;
}

absl::StatusOr<MissionRetiring::Taken> MissionRetiring::TakeNext() {
  absl::ReaderMutexLock lock(&strand_.mutex());
  const MissionState& state = strand_.state();
  const std::optional<RetiringStretch> stretch = passes_.Next(state);
  if (!stretch.has_value()) return absl::AbortedError("nothing may retire");
  const uint64_t revision = state.global.revision;
  PausingRead read(strand_, [this, revision]() ABSL_SHARED_LOCKS_REQUIRED(strand_.mutex()) {
    const bool goes_on = !strand_.deleted() && strand_.state().global.revision == revision;
    return goes_on ? absl::OkStatus() : absl::AbortedError("another revision was committed");
  });
  ASSIGN_OR_RETURN(RetiringView view,
                   TakeRetiringView(state, state.global.islands.at(stretch->island),
                                    stretch->keyframes, {}, read));
  return Taken{*stretch, std::move(view)};
}

bool MissionRetiring::Commit(const Taken& taken, const Retirement& retirement) {
  for (Retirement& part : CutIntoParts(retirement)) {
    if (!CommitPart(taken.view, {std::move(part)})) return false;
  }
  StateWriteLock lock(strand_);
  passes_.NoteDone(taken.stretch);
  return true;
}

bool MissionRetiring::CommitPart(const RetiringView& view, const RetireRecord& record) {
  absl::MutexLock turn(&strand_.turn());
  const MissionState& state = strand_.state_in_turn();
  if (strand_.IsDeleted() || !IsStillTrue(view, record.retirement.faded, state)) return false;
  // A journal with such a record would not be read again.
  if (const absl::Status sound = CheckRetirement(record.retirement, state); !sound.ok()) {
    LOG(ERROR) << "mission " << strand_.name() << " keeps what might retire: " << sound;
    return true;
  }
  if (!strand_.Append(record).ok()) return false;
  StateWriteLock lock(strand_);
  map_store::Apply(record, strand_.mutable_state());
  return true;
}

}  // namespace corbslam::map_store
