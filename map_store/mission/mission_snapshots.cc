#include "map_store/mission/mission_snapshots.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "map_store/archive/state_archive.h"
#include "map_store/records/unrecorded_state.h"
#include "slam/util/resident_memory.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// Says how much there is of a local map; a replay must come to the same.
struct Extent {
  uint64_t last_batch = 0;
  size_t keyframes = 0;
  size_t points = 0;

  bool operator==(const Extent&) const = default;
};

std::map<LocalMapId, Extent> Measure(const MissionState& state) {
  std::map<LocalMapId, Extent> extents;
  for (const auto& [id, local_map] : state.local_maps) {
    extents[id] = {local_map.last_batch, local_map.map.keyframes().size(),
                   local_map.map.points().size()};
  }
  return extents;
}

std::vector<std::shared_ptr<const KeyframePayload>> ListPayloads(const MissionState& state) {
  std::vector<std::shared_ptr<const KeyframePayload>> payloads;
  for (const auto& [id, local_map] : state.local_maps) {
    for (const auto& [keyframe_id, keyframe] : local_map.map.keyframes()) {
      payloads.push_back(keyframe.payload);
    }
  }
  return payloads;
}

}  // namespace

struct MissionSnapshots::Beginning {
  Journal::Position position = 0;
  ReplayProgress progress;
  UnrecordedState unrecorded;
  std::map<LocalMapId, Extent> extents;
  uint64_t changes = 0;
};

MissionSnapshots::Beginning MissionSnapshots::Begin() const {
  Beginning beginning;
  beginning.position = strand_.appended();
  absl::ReaderMutexLock lock(&strand_.mutex());
  beginning.progress = ProgressOf(strand_.state());
  beginning.unrecorded = CopyUnrecorded(strand_.state());
  beginning.extents = Measure(strand_.state());
  beginning.changes = strand_.changes();
  return beginning;
}

absl::StatusOr<MissionState> MissionSnapshots::Replay(Beginning& beginning,
                                                      const std::function<bool()>& goes_on,
                                                      const StateVisitor& visit) const {
  ASSIGN_OR_RETURN(MissionState state, strand_.ReplayUntil(beginning.position, goes_on, visit));
  if (Measure(state) != beginning.extents) {
    return absl::InternalError(absl::StrCat("mission ", strand_.name(), " replayed until record ",
                                            beginning.position, " is not what it was then"));
  }
  PutUnrecorded(std::move(beginning.unrecorded), state);
  return state;
}

absl::Status MissionSnapshots::Write(Beginning& beginning, const std::function<bool()>& goes_on) {
  const ReturnsFreeMemory after;
  ASSIGN_OR_RETURN(const MissionState state, Replay(beginning, goes_on));
  JournalSnapshot snapshot = TakeSnapshot(state);
  snapshot.position = beginning.position;
  if (snapshot.position == 0) {
    return absl::FailedPreconditionError(
        absl::StrCat("nothing of mission ", strand_.name(), " is in the journal"));
  }
  if (strand_.IsDeleted()) return absl::CancelledError("no snapshot any more");
  RETURN_IF_ERROR(strand_.environment().journal->WriteSnapshot(strand_.name(), snapshot));
  kept_changes_ = beginning.changes;
  return absl::OkStatus();
}

absl::StatusOr<bool> MissionSnapshots::Keep(const std::function<bool()>& goes_on) {
  // This is asked without the lock first: most calls find nothing to do.
  if (!strand_.environment().journal->WantsSnapshot(strand_.name())) return false;
  absl::MutexLock one(&mutex_);
  if (strand_.IsDeleted()) return false;
  if (!strand_.environment().journal->WantsSnapshot(strand_.name())) return false;
  Beginning beginning;
  {
    absl::MutexLock turn(&strand_.turn());
    beginning = Begin();
  }
  RETURN_IF_ERROR(Write(beginning, goes_on));
  return true;
}

absl::StatusOr<uint64_t> MissionSnapshots::KeepAll(const std::function<bool()>& goes_on) {
  // Whoever has the lock may wait for memory that only the caller can make free.
  if (!mutex_.TryLock()) {
    return absl::AbortedError(absl::StrCat("mission ", strand_.name(), " is being replayed"));
  }
  const absl::StatusOr<uint64_t> kept = KeepAllLocked(goes_on);
  mutex_.Unlock();
  return kept;
}

absl::StatusOr<uint64_t> MissionSnapshots::KeepAllLocked(const std::function<bool()>& goes_on) {
  Beginning beginning;
  {
    absl::MutexLock turn(&strand_.turn());
    beginning = Begin();
  }
  if (beginning.changes == kept_changes_) return beginning.changes;
  if (!goes_on()) return absl::CancelledError("nobody waits for the snapshot");
  RETURN_IF_ERROR(Write(beginning, goes_on));
  return kept_changes_;
}

absl::StatusOr<MissionBackup> MissionSnapshots::BackUp() {
  const Journal& journal = *strand_.environment().journal;
  // What a damaged journal can't give any more is still in memory.
  if (!journal.KeepsRecords() || !journal.Damage(strand_.name()).ok()) {
    return strand_.WithState([](const MissionState& state) { return MissionBackup(state); });
  }
  absl::MutexLock one(&mutex_);
  Beginning beginning;
  std::vector<std::shared_ptr<const KeyframePayload>> keyframes;
  {
    absl::MutexLock turn(&strand_.turn());
    beginning = Begin();
    keyframes = strand_.WithState(&ListPayloads);
  }
  const ReturnsFreeMemory after;
  ASSIGN_OR_RETURN(const MissionState state, Replay(beginning, [] { return true; }));
  return MissionBackup(EncodeState(state), std::move(keyframes));
}

absl::Status MissionSnapshots::CheckMemory(uint64_t bytes) const {
  return strand_.environment().memory->Check(absl::StrCat("the past of mission ", strand_.name()),
                                             bytes);
}

absl::StatusOr<std::vector<MapChanges>> MissionSnapshots::TellPast(
    const ReplayOptions& options, const std::function<bool()>& goes_on) {
  const auto check_memory = [this](uint64_t bytes) { return CheckMemory(bytes); };
  if (!strand_.environment().journal->KeepsRecords()) {
    absl::ReaderMutexLock lock(&strand_.mutex());
    MapReplay present(options, ProgressOf(strand_.state()), check_memory);
    RETURN_IF_ERROR(present.End(strand_.state()));
    return std::move(present).Take();
  }
  absl::MutexLock one(&mutex_);
  Beginning beginning;
  {
    absl::MutexLock turn(&strand_.turn());
    beginning = Begin();
  }
  const ReturnsFreeMemory after;
  MapReplay past(options, beginning.progress, check_memory);
  const absl::StatusOr<MissionState> state =
      Replay(beginning, goes_on, [&past](const MissionState& then) { return past.Note(then); });
  // The replay's own words of what has ended it would name the journal's folder.
  RETURN_IF_ERROR(past.status());
  if (strand_.IsDeleted()) return strand_.SayDeleted();
  RETURN_IF_ERROR(state.status());
  RETURN_IF_ERROR(past.End(*state));
  return std::move(past).Take();
}

}  // namespace corbslam::map_store
