// Pose graph over keyframes ("essential graph"): spreads a loop's or a fusion's correction.
#ifndef CORBSLAM_SLAM_OPTIMISATION_POSE_GRAPH_H_
#define CORBSLAM_SLAM_OPTIMISATION_POSE_GRAPH_H_

#include <map>
#include <vector>

#include "absl/container/btree_set.h"
#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/map.h"
#include "slam/optimisation/bundle_adjustment.h"
#include "slam/util/ids.h"

namespace corbslam {

// An edge says x_b = b_from_a * x_a in the cameras' frames.
struct PoseGraphEdge {
  KeyframeId a;
  KeyframeId b;
  Similarity3d b_from_a;
  // Multiplies the squared residual.
  double weight = 1;
  // True for an edge that may be wrong: if it disagrees with the rest it has no say. What counts is
  // weight * |residual|^2 against the 95 % bound of chi2 (12.6 rigid, 14.1 with scale), so with
  // weight and root_information it should be squared standard deviations.
  bool robust = false;
  // Upper triangular R: R^T * R is the information of the logarithm's components, up to `weight`.
  Matrix7d root_information = Matrix7d::Identity();
};

// Returns R for independent components: a turn by an angle, or a stretch by its logarithm, counts
// like a shift by as much of the scene's depth, in the units of b's camera. That is what pictures
// show.
Matrix7d RootInformationAtDepth(double depth);
// Returns R for the inverse of a positive definite covariance.
Matrix7d RootInformation(const Matrix7d& covariance);

struct PoseGraphOptions {
  // True: solves in SE(3) on the edges' rigid parts (metric maps), and the scales stay what they
  // are in `initial`, which must be 1. False: solves in Sim(3).
  bool fix_scale = true;
  // In Sim(3), keyframes that keep the scale that they have in `initial`: those of cameras that
  // measure metres, beside others that don't.
  absl::btree_set<KeyframeId> keep_scale = {};
  // Iterations of each solve; where robust edges disagree, there are some tens of solves.
  int max_iterations = 20;
  // Solver threads. With one, the same input gives the same bits every time.
  int threads = 1;
};

struct PoseGraphResult {
  std::map<KeyframeId, Similarity3d> camera_from_map;
  // 0.5 * the sum of weighted squared residuals; a robust edge adds at most the bound of chi2.
  double initial_cost = 0;
  double final_cost = 0;
  // weight * |residual|^2 of each input edge after optimisation, without loss.
  std::vector<double> edge_chi2;
  // True for each robust input edge that disagrees with the rest, and had no say.
  std::vector<bool> outvoted;
  int iterations = 0;
};

// The residual of an edge is R * log(b_from_a * camera_a_from_map * camera_b_from_map^-1), in the
// order (translation, rotation, log of scale). Fixed keyframes and those without edges stay. All
// robust edges pull at first, a true loop so however large the drift; where some then disagree
// beyond the bound, truncated least squares by graduated non-convexity decides between them,
// wherever the graph began, and losers get a second chance (docs/adr/0006). INVALID_ARGUMENT,
// naming the id, where an edge ends at an unknown keyframe or begins and ends at the same, a part
// of the graph has no fixed keyframe, or a value is not finite. Pure; any thread. Sources: Strasdat
// et al., RSS 2010 (scale drift-aware large scale monocular SLAM); Yang et al., "Graduated
// Non-Convexity for Robust Spatial Perception", RA-L 2020, algorithm 1.
absl::StatusOr<PoseGraphResult> OptimisePoseGraph(const std::map<KeyframeId, Similarity3d>& initial,
                                                  absl::Span<const PoseGraphEdge> edges,
                                                  const absl::btree_set<KeyframeId>& fixed,
                                                  const PoseGraphOptions& options);

// Returns the spanning tree, loop edges and covisibility of at least `min_covisibility` points,
// each pair of keyframes once with a < b, sorted; relative poses are the map's present ones, at the
// median depth of what b sees; where the map has none of that, at the median of the other
// keyframes' (1 for none).
std::vector<PoseGraphEdge> EssentialGraphEdges(const Map& map, int min_covisibility = 100);

// Returns where each point goes when it follows its reference keyframe to its corrected pose (which
// maps from the corrected map's frame). Points whose reference has none are left out. The result is
// sorted by id.
std::vector<PositionUpdate> MovePointsWithReferences(
    const Map& map, const std::map<KeyframeId, Similarity3d>& corrected);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_POSE_GRAPH_H_
