// Brings two maps into one frame, or closes loops inside one: the essential graph spreads the
// correction, duplicates become one landmark, and a window around the overlap is welded by bundle
// adjustment (CORB-SLAM, section 2.2; ORB-SLAM3, Campos et al., T-RO 2021, section VI.C).
#ifndef CORBSLAM_SLAM_FUSING_MAP_FUSING_H_
#define CORBSLAM_SLAM_FUSING_MAP_FUSING_H_

#include "absl/container/btree_set.h"
#include "absl/status/statusor.h"
#include "slam/exchange/fusion_worker.h"

namespace corbslam {

struct MapFusingOptions {
  // What changes results. Where valid, only keyframes of this local map move (a robot closing a
  // loop against what others made) but for its root, and the points that MovesWith says.
  LocalMapId only_moves;
  // At most so many keyframes of either side are adjusted by the welding.
  int welding_window = 10;
  int welding_iterations = 5;
  // A new overlap that still disagrees by more after the graph was solved refuses the whole, in
  // squared standard deviations: 2 % of the scene's depth, 0.01 rad, 5 % of scale. So does one that
  // the others left without a say, and so do new ones that make as many earlier ones disagree,
  // which agreed before, as they are themselves: what is in the map already yields to the greater
  // number only. Earlier ones that disagreed before, because others have outvoted them, refuse
  // nothing.
  double max_edge_chi2 = 50;
  // A loop that moves its keyframe, or what that sees, by more than this share of the way around it
  // (plus half the scene's depth) is refused: no odometry drifts that much. Tripled where scale is
  // free. The way may lead through other local maps where the overlap is the only new one.
  double max_drift = 0.1;
  // What changes speed. With one thread results repeat to the bit.
  int threads = 1;
};

// Returns the keyframes that stay: others', where `only_moves` is valid, and the root: the first of
// the rest that has no parent.
absl::btree_set<KeyframeId> KeyframesThatStay(const Map& map, LocalMapId only_moves);

// Says whether a point goes along where a local map's keyframes alone move: it does if it is one of
// theirs, or if no other keyframe of its map sees it.
bool MovesWith(LocalMapId local_map, const MapPoint& point);

// Fuses two maps, or closes loops in one. Rejected observations name points as they are after the
// merges. The result's poses have the scale of their keyframe's own unit over the target's: 1 for
// all of the target with `fix_scale`. INVALID_ARGUMENT, naming the id, for overlaps whose keyframes
// are in neither view, indices out of range, no new overlap or an id in both views; CANCELLED.
// Pure.
absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                        const MapFusingOptions& options,
                                        const ProgressCallback& progress);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FUSING_MAP_FUSING_H_
