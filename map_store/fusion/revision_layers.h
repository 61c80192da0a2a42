// What a plan makes of the global layer, computed before it is committed.
#ifndef CORBSLAM_MAP_STORE_FUSION_REVISION_LAYERS_H_
#define CORBSLAM_MAP_STORE_FUSION_REVISION_LAYERS_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "map_store/fusion/revision_plan.h"
#include "map_store/options/options.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/long_read.h"

namespace corbslam::map_store {

// What a plan makes of the global layer, as whole values. They are computed while others read the
// state, so that committing costs as much as changed hands and not as much as the map.
struct RevisionLayers {
  PlacedKeyframes keyframes;
  // Where many points are placed, all of them; else these alone, of which nullopt is not placed any
  // more.
  std::optional<PlacedPoints> points;
  std::vector<std::pair<MapPointId, std::optional<PlacedPoint>>> changed_points;
  // After an adjustment: all that fusion rejects, and keyframes whose rejections it takes back.
  std::optional<RejectedObservations> rejected;
  std::vector<KeyframeId> taken_back;
  // Frames of the local maps of the plan's islands.
  std::map<LocalMapId, Similarity3d> island_from_local;
  // Keyframes of the target that owners moved while the worker was busy.
  std::set<KeyframeId> displaced;
  // Keyframes that a welding moves by more than the options' residual.
  std::set<KeyframeId> moved;
  // After an adjustment: how many keyframes of the target are placed or culled.
  size_t adjusted = 0;

  // The mission's version when preparing began: what changed after it may be missing.
  uint64_t version = 0;
  // Points whose anchor the state had to choose.
  std::vector<MapPointId> chosen;
};

// Computes the layers. Between two pieces of the read owners may go on; then, or when time has
// passed since, RefreshLayers comes before the commit. Returns ABORTED as `read` does.
absl::StatusOr<RevisionLayers> PrepareLayers(const RevisionPlan& plan,
                                             const MapStoreOptions& options,
                                             const MissionState& state, LongRead& read);
// Computes them in one piece.
RevisionLayers PrepareLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                             const MissionState& state);
// Computes the same, but takes from the state what PrepareLayers would copy: for a replay, during
// which nobody reads. The layers are to be committed to that state next.
RevisionLayers TakeLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                          MissionState& state);
// Brings an adjustment's layers up to what owners have changed since they were prepared, so that
// they are as if they were prepared now; no other revision was committed meanwhile. Costs as much
// as was changed. Returns false, and leaves the layers useless, if the state does not remember
// that.
bool RefreshLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                   const MissionState& state, RevisionLayers& layers);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_REVISION_LAYERS_H_
