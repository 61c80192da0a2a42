#include "map_store/mission/mission_snapshots.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/archive/state_archive.h"
#include "map_store/records/unrecorded_state.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// How much there is of a local map: a replay must come to the same.
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

}  // namespace

absl::Status MissionSnapshots::Keep(const std::function<bool()>& goes_on) {
  absl::MutexLock one(&mutex_);
  Journal& journal = *strand_.environment().journal;
  if (!journal.WantsSnapshot(strand_.name())) return absl::OkStatus();
  Journal::Position position = 0;
  UnrecordedState unrecorded;
  std::map<LocalMapId, Extent> extents;
  {
    // No record comes between the state and its position.
    absl::MutexLock turn(&strand_.turn());
    position = strand_.appended();
    absl::ReaderMutexLock lock(&strand_.mutex());
    unrecorded = CopyUnrecorded(strand_.state());
    extents = Measure(strand_.state());
  }
  ASSIGN_OR_RETURN(MissionState state, strand_.ReplayUntil(position, goes_on));
  if (Measure(state) != extents) {
    return absl::InternalError(absl::StrCat("mission ", strand_.name(), " replayed until record ",
                                            position, " is not what it was then"));
  }
  PutUnrecorded(std::move(unrecorded), state);
  JournalSnapshot snapshot = TakeSnapshot(state);
  snapshot.position = position;
  if (strand_.IsDeleted()) return absl::CancelledError("no snapshot any more");
  return journal.WriteSnapshot(strand_.name(), snapshot);
}

}  // namespace corbslam::map_store
