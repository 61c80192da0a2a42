// Finds how two maps stand to each other, by what their overlaps say.
#ifndef CORBSLAM_SLAM_FUSING_MAP_ALIGNMENT_H_
#define CORBSLAM_SLAM_FUSING_MAP_ALIGNMENT_H_

#include <optional>
#include <vector>

#include "slam/exchange/overlap.h"
#include "slam/map/map.h"

namespace corbslam {

// An overlap seen from the keyframe that stays (`anchor`) and the one that is moved to it.
struct OrientedOverlap {
  KeyframeId anchor;
  KeyframeId mover;
  // The transform x_in_anchor_camera = anchor_from_mover * x_in_mover_camera.
  Similarity3d anchor_from_mover;
  // Covariance of e, where the true one is Exp(e) * anchor_from_mover (Overlap::covariance).
  Matrix7d covariance = Matrix7d::Zero();
  // Pairs of (anchor's point, mover's point).
  std::vector<std::pair<MapPointId, MapPointId>> points;
};

// The anchor is the candidate, or with `swap` the query.
OrientedOverlap Orient(const Overlap& overlap, bool swap);

// Returns anchor_map_from_mover_map as this overlap alone gives it. The keyframes must be in their
// maps.
Similarity3d AlignByOverlap(const Map& anchor_map, const Map& mover_map,
                            const OrientedOverlap& overlap);

// Returns the alignment of the overlap with which the others agree best (by their inliers): two
// agree where a mover comes to lie less than a tenth of its scene's depth apart, and their scales
// differ by less than a tenth. A single overlap gives its own alignment, none gives nullopt.
std::optional<Similarity3d> AlignByConsensus(const Map& anchor_map, const Map& mover_map,
                                             const std::vector<OrientedOverlap>& overlaps);

// Returns the median depth of the overlap's points before the anchor's camera. Where the map has
// none of them, it is that of all points that the anchor sees; 1 where it sees none.
double MedianDepth(const Map& anchor_map, const OrientedOverlap& overlap);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FUSING_MAP_ALIGNMENT_H_
