// The essential graph over one or two maps with overlaps as further edges.
#ifndef CORBSLAM_SLAM_FUSING_FUSING_GRAPH_H_
#define CORBSLAM_SLAM_FUSING_FUSING_GRAPH_H_

#include <map>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/exchange/fusion_worker.h"
#include "slam/fusing/map_alignment.h"
#include "slam/fusing/map_fusing.h"

namespace corbslam {

// The state that fusing starts from: the two maps (the source empty for loops), their overlaps with
// the anchor on the target's side, and how the source is first placed.
struct FusingProblem {
  const Map* target = nullptr;
  const Map* source = nullptr;
  std::vector<OrientedOverlap> overlaps;
  std::vector<size_t> new_overlaps;
  Similarity3d target_from_source;
  bool fix_scale = true;
  // Where scales are free: keyframes whose cameras measure metres, if the target has some. Theirs
  // are not estimated anew.
  absl::btree_set<KeyframeId> in_metres = {};

  // Returns the map that holds a keyframe of either.
  const Map& MapOf(KeyframeId id) const {
    return target->FindKeyframe(id) != nullptr ? *target : *source;
  }
  bool HasOneNewOverlap() const { return new_overlaps.size() == 1; }
  // True for an overlap between the two maps, false inside one.
  bool IsCrossing(const OrientedOverlap& overlap) const {
    return &MapOf(overlap.anchor) != &MapOf(overlap.mover);
  }
};

struct SolvedGraph {
  // Poses of all keyframes, in the target's frame.
  std::map<KeyframeId, Similarity3d> camera_from_target;
  // Keyframes that were held fixed.
  absl::btree_set<KeyframeId> fixed;
  // Chi2 of each overlap before and after, in squared standard deviations (MapFusingOptions).
  std::vector<double> initial_chi2;
  std::vector<double> chi2;
  // True for each overlap that the others left without a say.
  std::vector<bool> outvoted;
};

absl::StatusOr<SolvedGraph> SolveFusingGraph(const FusingProblem& problem,
                                             const MapFusingOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FUSING_FUSING_GRAPH_H_
