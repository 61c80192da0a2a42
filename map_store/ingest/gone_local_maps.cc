#include "map_store/ingest/gone_local_maps.h"

#include "absl/strings/str_cat.h"

namespace corbslam::map_store {

absl::Status CheckTakesBatches(const MissionState& state, LocalMapId local_map) {
  if (state.forgotten.contains(local_map)) {
    return absl::FailedPreconditionError(absl::StrCat(
        "local map ", ToString(local_map), " of mission ", state.name,
        " was deleted by an administrator: nothing is added to it; begin a new local map"));
  }
  const LocalMapId whole = state.OwnerOf(local_map);
  if (whole == local_map) {
    const auto it = state.local_maps.find(local_map);
    if (it == state.local_maps.end() || it->second.joined.empty()) return absl::OkStatus();
    // Its frames would count as those of the last part.
    return absl::FailedPreconditionError(
        absl::StrCat("local map ", ToString(local_map), " of mission ", state.name,
                     " was closed, and later ones of its agent have become parts of it: nothing is "
                     "added to it; begin a new local map"));
  }
  return absl::FailedPreconditionError(
      absl::StrCat("local map ", ToString(local_map), " of mission ", state.name,
                   " was closed and has been retired into local map ", ToString(whole),
                   ": nothing is added to it; begin a new local map"));
}

}  // namespace corbslam::map_store
