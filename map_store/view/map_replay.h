// Tells the map as it was at moments of the past, while somebody brings a mission's state through
// them.
#ifndef CORBSLAM_MAP_STORE_VIEW_MAP_REPLAY_H_
#define CORBSLAM_MAP_STORE_VIEW_MAP_REPLAY_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "map_store/state/lookups.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/even_steps.h"
#include "map_store/view/map_watcher.h"

namespace corbslam::map_store {

struct ReplayOptions {
  bool include_points = false;
  // Moments: revisions and, where there is room, batches between them. Of more than this, about
  // evenly chosen ones are told; 2 to 1,000.
  size_t max_moments = 100;
  // Bytes of all that is told, as it is held in memory; on the wire it is no more.
  uint64_t max_bytes = uint64_t{256} << 20;

  // Returns INVALID_ARGUMENT, naming the field, if an option is out of its range.
  absl::Status Validate() const;
};

// How far a mission has come.
struct ReplayProgress {
  uint64_t revision = 0;
  uint64_t batches = 0;  // Of all local maps that are there.
};

ReplayProgress ProgressOf(const MissionState& state);

// Collects a replay: the first state that it sees, then what changed up to each chosen moment, and
// up to the end. A moment comes behind a batch or with a revision: all of those are chosen if there
// is room; else up to half of the moments are revisions, and the others are spread over the
// batches. A value; not thread-safe.
class MapReplay {
 public:
  // Says whether so many bytes more may be held.
  using MemoryCheck = std::function<absl::Status(uint64_t bytes)>;

  // The states that it is shown end at `last`. `options` must be valid.
  MapReplay(const ReplayOptions& options, const ReplayProgress& last, MemoryCheck memory);

  // Looks at the state as the next record has left it. An error ends the replay: RESOURCE_EXHAUSTED
  // if it is too long.
  absl::Status Note(const MissionState& state);
  // Looks at the state as it was at the end, which is told in any case.
  absl::Status End(const MissionState& state);
  // Returns the error that has ended it.
  const absl::Status& status() const { return status_; }
  // Returns all pieces, in order; each moment's last one does not say `continues`.
  std::vector<MapChanges> Take() && { return std::move(pieces_); }

 private:
  // The moments that are to be told.
  struct Plan {
    EvenSteps revisions;
    EvenSteps batches;
  };

  Plan MakePlan(const ReplayProgress& first) const;
  absl::Status Tell(const MissionState& state);
  absl::Status Keep(MapChanges piece);

  const ReplayOptions options_;
  const ReplayProgress last_;
  const MemoryCheck memory_;
  MapWatcher watcher_;
  std::optional<Plan> plan_;  // Once there was a state.
  uint64_t bytes_ = 0;
  std::vector<MapChanges> pieces_;
  absl::Status status_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_MAP_REPLAY_H_
