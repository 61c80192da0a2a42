#include "slam/fusing/fusing_graph.h"

#include <algorithm>
#include <cmath>

#include "absl/container/btree_map.h"
#include "slam/optimisation/pose_graph.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// Standard deviation of one edge of odometry against an overlap that has no covariance: loose
// enough for a loop to close, stiff enough not to take on the overlap's own noise. In shares of the
// scene's depth and in rad.
constexpr double kOdometrySigma = 0.063;
// What an overlap may be off beyond its inliers' noise, because the maps themselves are not exact.
constexpr double kOverlapSigma = 0.02;
constexpr double kOverlapSigmaLogScale = 0.05;
// Standard deviations in which MapFusingOptions::max_edge_chi2 is counted.
constexpr double kSigmaShareOfDepth = 0.02;
constexpr double kSigmaAngle_rad = 0.01;
constexpr double kSigmaLogScale = 0.05;
// An earlier overlap agrees with the map within this, in squared standard deviations.
constexpr double kMaxChi2InTarget = 1;

std::map<KeyframeId, Similarity3d> InitialPoses(const FusingProblem& problem) {
  std::map<KeyframeId, Similarity3d> poses;
  for (const auto& [id, keyframe] : problem.target->keyframes()) {
    poses.emplace(id, Similarity3d::FromRigid(keyframe.camera_from_map));
  }
  const Similarity3d source_from_target = problem.target_from_source.Inverse();
  for (const auto& [id, keyframe] : problem.source->keyframes()) {
    poses.emplace(id, Similarity3d::FromRigid(keyframe.camera_from_map) * source_from_target);
  }
  return poses;
}

// An earlier overlap that agrees with the target says no more than the target does: what its
// keyframes see has become one there, and was adjusted since. Its own measurement, with the noise
// of one pair of views, would undo that: a hundredth of a radian is a metre 100 m on.
bool IsInTarget(const FusingProblem& problem, size_t index, double initial_chi2) {
  const bool is_new = std::ranges::find(problem.new_overlaps, index) != problem.new_overlaps.end();
  const OrientedOverlap& overlap = problem.overlaps[index];
  return !is_new && initial_chi2 <= kMaxChi2InTarget &&
         problem.target->FindKeyframe(overlap.anchor) != nullptr &&
         problem.target->FindKeyframe(overlap.mover) != nullptr;
}

PoseGraphEdge OverlapEdge(const OrientedOverlap& overlap, double depth) {
  Vector7d sigma = Vector7d::Constant(kOverlapSigma);
  sigma.head<3>() *= depth;
  sigma[6] = kOverlapSigmaLogScale;
  Matrix7d covariance = overlap.covariance;
  covariance.diagonal() += sigma.cwiseAbs2();
  return {.a = overlap.mover,
          .b = overlap.anchor,
          .b_from_a = overlap.anchor_from_mover,
          .robust = true,
          .root_information = RootInformation(covariance)};
}

// Lists the graph's edges, with the overlaps last.
std::vector<PoseGraphEdge> Edges(const FusingProblem& problem, const std::vector<double>& depths,
                                 const std::map<KeyframeId, Similarity3d>& initial,
                                 const std::vector<double>& initial_chi2) {
  std::vector<PoseGraphEdge> edges = EssentialGraphEdges(*problem.target);
  const std::vector<PoseGraphEdge> of_source = EssentialGraphEdges(*problem.source);
  edges.insert(edges.end(), of_source.begin(), of_source.end());
  for (PoseGraphEdge& edge : edges) edge.weight = 1 / (kOdometrySigma * kOdometrySigma);
  for (size_t i = 0; i < problem.overlaps.size(); ++i) {
    const OrientedOverlap& overlap = problem.overlaps[i];
    edges.push_back(OverlapEdge(overlap, depths[i]));
    if (!IsInTarget(problem, i, initial_chi2[i])) continue;
    edges.back().b_from_a = initial.at(overlap.anchor) * initial.at(overlap.mover).Inverse();
  }
  return edges;
}

using Labels = absl::btree_map<KeyframeId, KeyframeId>;

KeyframeId FindLabel(Labels& labels, KeyframeId id) {
  while (labels[id] != id) id = labels[id] = labels[labels[id]];
  return id;
}

// Every part of the graph needs a keyframe that holds it; where none is held yet, it is the lowest.
void FixEveryPart(const std::map<KeyframeId, Similarity3d>& poses,
                  const std::vector<PoseGraphEdge>& edges, absl::btree_set<KeyframeId>& fixed) {
  Labels labels;
  for (const auto& [id, pose] : poses) labels[id] = id;
  for (const PoseGraphEdge& edge : edges) {
    const KeyframeId a = FindLabel(labels, edge.a);
    const KeyframeId b = FindLabel(labels, edge.b);
    labels[std::max(a, b)] = std::min(a, b);
  }
  absl::btree_set<KeyframeId> held;
  for (const KeyframeId& id : fixed) held.insert(FindLabel(labels, id));
  for (const auto& [id, pose] : poses) {
    if (held.insert(FindLabel(labels, id)).second) fixed.insert(id);
  }
}

std::vector<double> MedianDepths(const FusingProblem& problem) {
  std::vector<double> depths;
  depths.reserve(problem.overlaps.size());
  for (const OrientedOverlap& overlap : problem.overlaps) {
    depths.push_back(MedianDepth(problem.MapOf(overlap.anchor), overlap));
  }
  return depths;
}

double Chi2(const OrientedOverlap& overlap, double depth,
            const std::map<KeyframeId, Similarity3d>& poses) {
  const Similarity3d error =
      overlap.anchor_from_mover * poses.at(overlap.mover) * poses.at(overlap.anchor).Inverse();
  const double shift = error.translation.norm() / (kSigmaShareOfDepth * depth);
  const double turn = RotationAngle(error.rotation) / kSigmaAngle_rad;
  const double stretch = std::log(error.scale) / kSigmaLogScale;
  return shift * shift + turn * turn + stretch * stretch;
}

// Computes the chi2 of every overlap.
std::vector<double> Chi2s(const FusingProblem& problem, const std::vector<double>& depths,
                          const std::map<KeyframeId, Similarity3d>& poses) {
  std::vector<double> chi2;
  chi2.reserve(depths.size());
  for (size_t i = 0; i < depths.size(); ++i) {
    chi2.push_back(Chi2(problem.overlaps[i], depths[i], poses));
  }
  return chi2;
}

}  // namespace

absl::StatusOr<SolvedGraph> SolveFusingGraph(const FusingProblem& problem,
                                             const MapFusingOptions& options) {
  const std::map<KeyframeId, Similarity3d> initial = InitialPoses(problem);
  const std::vector<double> depths = MedianDepths(problem);
  SolvedGraph solved;
  solved.initial_chi2 = Chi2s(problem, depths, initial);
  const std::vector<PoseGraphEdge> edges = Edges(problem, depths, initial, solved.initial_chi2);
  solved.fixed = KeyframesThatStay(*problem.target, options.only_moves);
  FixEveryPart(initial, edges, solved.fixed);
  PoseGraphOptions graph;
  graph.fix_scale = problem.fix_scale;
  graph.keep_scale = problem.in_metres;
  graph.threads = options.threads;
  ASSIGN_OR_RETURN(PoseGraphResult result, OptimisePoseGraph(initial, edges, solved.fixed, graph));
  solved.camera_from_target = std::move(result.camera_from_map);
  for (const auto& [id, pose] : initial) solved.camera_from_target.try_emplace(id, pose);
  solved.outvoted.assign(result.outvoted.end() - static_cast<ptrdiff_t>(problem.overlaps.size()),
                         result.outvoted.end());
  solved.chi2 = Chi2s(problem, depths, solved.camera_from_target);
  return solved;
}

}  // namespace corbslam
