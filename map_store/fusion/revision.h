// Leads from a worker's result to a committed revision of the global layer. Planning reads the
// state as it is now, so that what came, moved or went since the snapshot is respected; applying
// only writes what was planned.
#ifndef CORBSLAM_MAP_STORE_FUSION_REVISION_H_
#define CORBSLAM_MAP_STORE_FUSION_REVISION_H_

#include <Eigen/Core>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/time/time.h"
#include "map_store/fusion/fusion_job.h"
#include "map_store/options.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

// A position that a plan gives to a point, in the frame of the plan's target.
struct PlannedPoint {
  Eigen::Vector3d position_in_island = Eigen::Vector3d::Zero();
  uint64_t revision = 0;
};
using PlannedPoints = absl::btree_map<MapPointId, PlannedPoint>;

struct RevisionPlan {
  uint64_t revision = 0;
  IslandId target;
  IslandId source;  // The island that moves into `target`; invalid: none does.
  std::map<KeyframeId, PlacedKeyframe> keyframes;
  // All other placed points keep their places in the keyframes that they are anchored in.
  PlannedPoints points;
  std::vector<FuseMapsResult::Merge> merges;
  // Raw observations that were found wrong, and keyframes whose earlier rejections the plan takes
  // back.
  RejectedObservations rejected_raw;
  std::set<KeyframeId> decided_anew;
  std::vector<KeyframeId> culled;
  std::vector<uint64_t> overlaps;  // Overlaps that are in the graph from now on.

  // Returns whether it is of a global bundle adjustment, which decides anew about each keyframe
  // that it saw.
  bool IsAdjustment() const { return !decided_anew.empty(); }
  bool IsWelding() const { return !IsAdjustment() && !source.IsValid(); }
};

// Plans the result's poses; a keyframe without one keeps its pose of the snapshot that the worker
// saw. Only settled keyframes are placed: provisional ones still follow their robot's adjustment.
// Removed keyframes, and points whose reference keyframe is not placed, are skipped.
RevisionPlan PlanFuse(const MissionState& state, const FuseJob& job, const FuseMapsResult& result);
RevisionPlan PlanAdjust(const MissionState& state, const AdjustJob& job,
                        const AdjustBundleResult& result);

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
};

// Computes the layers; `state` is as it was when the plan was made.
RevisionLayers PrepareLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                             const MissionState& state);
// Computes the same, but takes from the state what PrepareLayers would copy: for a replay, during
// which nobody reads. The layers are to be committed to that state next.
RevisionLayers TakeLayers(const RevisionPlan& plan, const MapStoreOptions& options,
                          MissionState& state);

// Writes the plan and puts the layers in place; `layers` holds the old ones afterwards.
void CommitRevision(const RevisionPlan& plan, RevisionLayers& layers, MissionState& state);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_REVISION_H_
