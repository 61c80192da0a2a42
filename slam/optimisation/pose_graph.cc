#include "slam/optimisation/pose_graph.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/map/scene_depth.h"
#include "slam/optimisation/pose_graph_problem.h"
#include "slam/optimisation/robust_edges.h"
#include "slam/util/median.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

using Poses = std::map<KeyframeId, Similarity3d>;

bool IsFinite(const Similarity3d& s) {
  return std::isfinite(s.scale) && s.scale > 0 && s.rotation.coeffs().allFinite() &&
         s.translation.allFinite();
}

absl::Status CheckPoses(const Poses& poses, bool fix_scale) {
  for (const auto& [id, pose] : poses) {
    if (!IsFinite(pose)) {
      return absl::InvalidArgumentError(
          absl::StrCat("pose graph: pose of keyframe ", ToString(id), " is not finite"));
    }
    if (fix_scale && std::abs(pose.scale - 1) > 1e-9) {
      return absl::InvalidArgumentError(absl::StrCat("pose graph: scale of keyframe ", ToString(id),
                                                     " is ", pose.scale, ", must be 1"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckEdges(const Poses& poses, absl::Span<const PoseGraphEdge> edges) {
  for (const PoseGraphEdge& edge : edges) {
    for (const KeyframeId id : {edge.a, edge.b}) {
      if (poses.contains(id)) continue;
      return absl::InvalidArgumentError(
          absl::StrCat("pose graph: an edge ends at unknown keyframe ", ToString(id)));
    }
    if (edge.a == edge.b) {
      return absl::InvalidArgumentError(
          absl::StrCat("pose graph: an edge joins keyframe ", ToString(edge.a), " to itself"));
    }
    if (!IsFinite(edge.b_from_a) || !std::isfinite(edge.weight) || edge.weight <= 0 ||
        !edge.root_information.allFinite()) {
      return absl::InvalidArgumentError(
          absl::StrCat("pose graph: edge ", ToString(edge.a), " - ", ToString(edge.b),
                       " has a value that is not finite, or weight ", edge.weight));
    }
  }
  return absl::OkStatus();
}

// Every keyframe that an edge touches must hang together with a fixed one.
absl::Status CheckAnchored(const Poses& poses, absl::Span<const PoseGraphEdge> edges,
                           const absl::btree_set<KeyframeId>& fixed) {
  std::map<KeyframeId, std::vector<KeyframeId>> neighbours;
  for (const PoseGraphEdge& edge : edges) {
    neighbours[edge.a].push_back(edge.b);
    neighbours[edge.b].push_back(edge.a);
  }
  std::vector<KeyframeId> to_visit;
  std::set<KeyframeId> reached;
  for (const KeyframeId id : fixed) {
    if (!poses.contains(id)) {
      return absl::InvalidArgumentError(
          absl::StrCat("pose graph: fixed keyframe ", ToString(id), " is unknown"));
    }
    reached.insert(id);
    to_visit.push_back(id);
  }
  while (!to_visit.empty()) {
    const KeyframeId id = to_visit.back();
    to_visit.pop_back();
    for (const KeyframeId next : neighbours[id]) {
      if (reached.insert(next).second) to_visit.push_back(next);
    }
  }
  for (const PoseGraphEdge& edge : edges) {
    if (reached.contains(edge.a)) continue;
    return absl::InvalidArgumentError(
        absl::StrCat("pose graph: keyframe ", ToString(edge.a), " is joined to no fixed keyframe"));
  }
  return absl::OkStatus();
}

// A view may hold the points of a part alone: the others' depth is the median of those known.
std::map<KeyframeId, double> DepthsOfKeyframes(const Map& map) {
  std::map<KeyframeId, double> depths;
  std::vector<double> known;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const std::optional<double> depth = MedianDepth(map, keyframe);
    if (!depth.has_value()) continue;
    depths.emplace(id, *depth);
    known.push_back(*depth);
  }
  const double of_others = known.empty() ? 1 : Median(std::move(known));
  for (const auto& [id, keyframe] : map.keyframes()) depths.try_emplace(id, of_others);
  return depths;
}

PoseGraphEdge PresentEdge(const Map& map, const std::map<KeyframeId, double>& depths, KeyframeId a,
                          KeyframeId b) {
  PoseGraphEdge edge{a, b,
                     Similarity3d::FromRigid(map.FindKeyframe(b)->camera_from_map *
                                             map.FindKeyframe(a)->camera_from_map.Inverse())};
  edge.root_information = RootInformationAtDepth(depths.at(b));
  return edge;
}

}  // namespace

Matrix7d RootInformationAtDepth(double depth) {
  Vector7d diagonal = Vector7d::Ones();
  diagonal.head<3>() /= depth;
  return diagonal.asDiagonal();
}

Matrix7d RootInformation(const Matrix7d& covariance) {
  return covariance.inverse().llt().matrixU();
}

absl::StatusOr<PoseGraphResult> OptimisePoseGraph(const Poses& initial,
                                                  absl::Span<const PoseGraphEdge> edges,
                                                  const absl::btree_set<KeyframeId>& fixed,
                                                  const PoseGraphOptions& options) {
  RETURN_IF_ERROR(CheckPoses(initial, options.fix_scale));
  RETURN_IF_ERROR(CheckEdges(initial, edges));
  RETURN_IF_ERROR(CheckAnchored(initial, edges, fixed));
  std::vector<PoseGraphEdge> measured(edges.begin(), edges.end());
  if (options.fix_scale) {
    for (PoseGraphEdge& edge : measured) edge.b_from_a.scale = 1;
  }
  PoseGraphProblem problem(initial, measured, fixed, options);
  PoseGraphResult result;
  result.initial_cost = problem.TruncatedCost(problem.EdgeChi2());
  RETURN_IF_ERROR(SolveRobustly(problem));
  result.edge_chi2 = problem.EdgeChi2();
  result.outvoted.resize(edges.size());
  for (const size_t edge : problem.robust()) {
    result.outvoted[edge] = result.edge_chi2[edge] > problem.max_chi2();
  }
  result.final_cost = problem.TruncatedCost(result.edge_chi2);
  result.iterations = problem.iterations();
  for (const auto& [id, block] : problem.poses()) {
    result.camera_from_map[id] = fixed.contains(id) ? initial.at(id) : FromBlock(block.data());
  }
  return result;
}

std::vector<PoseGraphEdge> EssentialGraphEdges(const Map& map, int min_covisibility) {
  std::set<std::pair<KeyframeId, KeyframeId>> pairs;
  const auto add = [&](KeyframeId a, KeyframeId b) {
    if (map.FindKeyframe(b) != nullptr) pairs.emplace(std::min(a, b), std::max(a, b));
  };
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframe.parent.IsValid()) add(id, keyframe.parent);
    for (const KeyframeId other : keyframe.loop_edges) add(id, other);
    for (const auto& [other, weight] : keyframe.covisible) {
      if (weight >= min_covisibility) add(id, other);
    }
  }
  std::vector<PoseGraphEdge> edges;
  edges.reserve(pairs.size());
  const std::map<KeyframeId, double> depths = DepthsOfKeyframes(map);
  for (const auto& [a, b] : pairs) edges.push_back(PresentEdge(map, depths, a, b));
  return edges;
}

std::vector<PositionUpdate> MovePointsWithReferences(const Map& map, const Poses& corrected) {
  std::map<KeyframeId, Similarity3d> corrected_from_map;
  for (const auto& [id, pose] : corrected) {
    const Keyframe* keyframe = map.FindKeyframe(id);
    if (keyframe == nullptr) continue;
    corrected_from_map[id] = pose.Inverse() * Similarity3d::FromRigid(keyframe->camera_from_map);
  }
  std::vector<PositionUpdate> updates;
  for (const auto& [id, point] : map.points()) {
    const auto it = corrected_from_map.find(point.reference);
    if (it != corrected_from_map.end()) updates.push_back({id, it->second * point.position_in_map});
  }
  return updates;
}

}  // namespace corbslam
