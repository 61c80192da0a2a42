// From a worker's result to a committed revision of the global layer. Planning reads the state as
// it is now, so that what came, moved or went since the snapshot is respected; applying only writes
// what was planned.
#ifndef CORBSLAM_MAP_STORE_FUSION_REVISION_H_
#define CORBSLAM_MAP_STORE_FUSION_REVISION_H_

#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "map_store/fusion/fusion_job.h"
#include "map_store/options.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

struct RevisionPlan {
  uint64_t revision = 0;
  IslandId target;
  IslandId source;  // Moves into `target`; invalid: none does.
  std::map<KeyframeId, PlacedKeyframe> keyframes;
  PlacedPoints points;
  std::vector<FuseMapsResult::Merge> merges;
  // Raw observations that were found wrong, and keyframes whose earlier rejections it takes back.
  RejectedObservations rejected_raw;
  std::set<KeyframeId> decided_anew;
  std::vector<KeyframeId> culled;
  std::vector<uint64_t> overlaps;  // Now in the graph.

  // Of a global bundle adjustment, which decides anew about each keyframe that it saw.
  bool IsAdjustment() const { return !decided_anew.empty(); }
  bool IsWelding() const { return !IsAdjustment() && !source.IsValid(); }
};

// Keyframes get the result's pose, else the one of the snapshot that the worker saw. Only settled
// ones are placed: provisional ones still follow their robot's adjustment. Removed ones, and points
// whose reference keyframe is not placed, are skipped. Fusing sees few of the points: the others
// follow their reference keyframes.
RevisionPlan PlanFuse(const MissionState& state, const FuseJob& job, const FuseMapsResult& result);
RevisionPlan PlanAdjust(const MissionState& state, const AdjustJob& job,
                        const AdjustBundleResult& result);

// What a plan makes of the global layer, as whole values: computed beside those who read the state,
// so that committing it costs as much as changed hands and not as the map.
struct RevisionLayers {
  PlacedKeyframes keyframes;
  PlacedPoints points;
  std::map<LocalMapId, Similarity3d> island_from_local;  // Of the local maps of the plan's islands.
  // Of the target: what owners moved while the worker was busy.
  std::set<KeyframeId> displaced;
  // Of a welding: keyframes that it moves by more than the options' residual.
  std::set<KeyframeId> moved;
  // Of an adjustment: how many keyframes of the target are placed or culled then.
  size_t adjusted = 0;
};

// `state` is as it was when the plan was made.
RevisionLayers PrepareLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                             const MissionState& state);
// Likewise, with what PrepareLayers would copy taken from the state: for a replay, which nobody
// reads meanwhile. They are to be committed to it next.
RevisionLayers TakeLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                          MissionState& state);

// Writes the plan and puts the layers in place; the old ones are in `layers` then.
void CommitRevision(const RevisionPlan& plan, RevisionLayers& layers, MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_REVISION_H_
