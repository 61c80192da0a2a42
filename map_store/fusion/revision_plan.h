// Leads from a worker's result to the plan of a revision of the global layer. Planning reads the
// state as it is now, so that what came, moved or went since the snapshot is respected.
#ifndef CORBSLAM_MAP_STORE_FUSION_REVISION_PLAN_H_
#define CORBSLAM_MAP_STORE_FUSION_REVISION_PLAN_H_

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "absl/container/btree_map.h"
#include "absl/status/statusor.h"
#include "map_store/fusion/fusion_job.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/long_read.h"

namespace corbslam::map_store {

// A position that a plan gives to a point, in the frame of the plan's target, and the keyframe in
// which the point is to be anchored. Invalid: the state decides when the plan is applied.
struct PlannedPoint {
  Eigen::Vector3d position_in_island = Eigen::Vector3d::Zero();
  uint64_t revision = 0;
  KeyframeId anchor = {};
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
// Removed keyframes, and points whose reference keyframe is not placed, are skipped. Owners may go
// on while an adjustment is planned, and until it is applied: applying skips what has gone since.
// Returns ABORTED as `read` does.
absl::StatusOr<RevisionPlan> PlanAdjust(const MissionState& state, const AdjustJob& job,
                                        const AdjustBundleResult& result, LongRead& read);
// Plans the same of a fusing, in one piece.
RevisionPlan PlanFuse(const MissionState& state, const FuseJob& job, const FuseMapsResult& result);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_FUSION_REVISION_PLAN_H_
