#include "map_store/coordination/mission_joining.h"

#include <glog/logging.h>

#include "absl/strings/str_cat.h"
#include "map_store/records/record_application.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {

std::optional<LocalMapJoining> MissionJoining::Choose(const MissionState& state) const {
  absl::MutexLock lock(&memory_mutex_);
  return ChooseJoining(state, strand_.options().keep_local_maps, memory_);
}

bool MissionJoining::IsDue() const {
  if (!IsWanted() || strand_.IsDamaged()) return false;
  absl::ReaderMutexLock lock(&strand_.mutex());
  const MissionState& state = strand_.state();
  if (strand_.deleted() || rests_at_.load() == state.version + 1) return false;
  if (Choose(state).has_value()) return true;
  rests_at_.store(state.version + 1);
  return false;
}

bool MissionJoining::RunOne() {
  // IsDue looks at all local maps after each batch: it comes last.
  if (!fusion_.RestsButForQueries() || retiring_.IsDue() || !IsDue()) return false;
  {
    absl::MutexLock turn(&strand_.turn());
    // Another thread may have begun to fuse since.
    if (strand_.IsDeleted() || !fusion_.RestsButForQueries()) return false;
    // Sessions open without the turn, and agents come with them.
    const std::optional<LocalMapJoining> joining =
        strand_.WithState([this](const MissionState& state) { return Choose(state); });
    if (!joining.has_value()) return false;
    const JoinRecord record{*joining};
    if (!strand_.Append(record).ok()) return false;
    StateWriteLock lock(strand_);
    map_store::Apply(record, strand_.mutable_state());
    LOG(INFO) << "mission " << strand_.name() << ": local map " << ToString(joining->part)
              << " is a part of local map " << ToString(joining->whole) << " from here on";
  }
  notify_();
  return true;
}

absl::StatusOr<ForgottenLocalMaps> MissionJoining::Forget(const ForgetRequest& request) {
  ForgottenLocalMaps forgotten;
  {
    absl::MutexLock turn(&strand_.turn());
    if (strand_.IsDeleted()) return strand_.SayDeleted();
    ASSIGN_OR_RETURN(forgotten, strand_.WithState([&](const MissionState& state) {
      return ChooseForgotten(request, state);
    }));
    if (request.dry_run || forgotten.local_maps.empty()) return forgotten;
    if (!fusion_.IsIdle()) {
      return absl::FailedPreconditionError(
          absl::StrCat("mission ", strand_.name(),
                       " is being fused: try again when `corbslam mission show` says that fusion "
                       "is idle"));
    }
    const ForgetRecord record{forgotten.local_maps};
    RETURN_IF_ERROR(strand_.Append(record));
    StateWriteLock lock(strand_);
    map_store::Apply(record, strand_.mutable_state());
  }
  RETURN_IF_ERROR(strand_.Sync());
  notify_();
  return forgotten;
}

}  // namespace corbslam::map_store
