#include "slam/optimisation/pose_graph.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/optimisation/graduated_non_convexity.h"
#include "slam/optimisation/relative_pose_cost.h"
#include "slam/optimisation/similarity_manifold.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

using Poses = std::map<KeyframeId, Similarity3d>;
using Blocks = std::map<KeyframeId, SimilarityBlock>;

// 95 % bounds of chi2 with six and seven degrees of freedom.
constexpr double kChi2Rigid = 12.592;
constexpr double kChi2Similarity = 14.067;
// A switched-off edge still holds the graph together.
constexpr double kLeastWeight = 1e-9;
constexpr int kMaxRounds = 100;

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
    if (!IsFinite(edge.b_from_a) || !std::isfinite(edge.weight) || edge.weight <= 0) {
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

// `weights` are those of the robust edges, one an edge; the caller's.
template <int kTangent>
void AddEdges(absl::Span<const PoseGraphEdge> edges, const absl::btree_set<KeyframeId>& fixed,
              std::vector<AdjustableWeight>& weights, Blocks& blocks, ceres::Problem& problem) {
  // Shared; the problem deletes it once.
  auto* manifold = new LeftPerturbation<kTangent>();
  for (size_t i = 0; i < edges.size(); ++i) {
    const PoseGraphEdge& edge = edges[i];
    problem.AddResidualBlock(new RelativePoseCost<kTangent>(edge.b_from_a, edge.weight),
                             edge.robust ? &weights[i] : nullptr, blocks.at(edge.a).data(),
                             blocks.at(edge.b).data());
  }
  bool is_used = false;
  for (auto& [id, block] : blocks) {
    if (!problem.HasParameterBlock(block.data())) continue;
    problem.SetManifold(block.data(), manifold);
    is_used = true;
    if (fixed.contains(id)) problem.SetParameterBlockConstant(block.data());
  }
  if (!is_used) delete manifold;
}

// weight * |residual|^2 of each edge.
std::vector<double> EdgeChi2(absl::Span<const PoseGraphEdge> edges, const Blocks& blocks,
                             bool fix_scale) {
  std::vector<double> chi2;
  for (const PoseGraphEdge& edge : edges) {
    const Vector7d error = LogSim3(edge.b_from_a * FromBlock(blocks.at(edge.a).data()) *
                                   FromBlock(blocks.at(edge.b).data()).Inverse());
    chi2.push_back(edge.weight * (fix_scale ? error.head<6>().squaredNorm() : error.squaredNorm()));
  }
  return chi2;
}

ceres::Solver::Options SolverOptions(const PoseGraphOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = options.threads;
  solver.logging_type = ceres::SILENT;
  // The graph begins near its minimum: trust the first Gauss-Newton step.
  solver.initial_trust_region_radius = 1e16;
  return solver;
}

absl::Status Solve(const PoseGraphOptions& options, ceres::Problem& problem,
                   PoseGraphResult& result) {
  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(options), &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    return absl::InternalError(absl::StrCat("pose graph: ", summary.message));
  }
  result.iterations += static_cast<int>(summary.iterations.size());
  return absl::OkStatus();
}

double MaxChi2(const PoseGraphOptions& options) {
  return options.fix_scale ? kChi2Rigid : kChi2Similarity;
}

double TruncatedCost(absl::Span<const PoseGraphEdge> edges, const std::vector<double>& chi2,
                     double max_chi2) {
  double cost = 0;
  for (size_t i = 0; i < edges.size(); ++i) {
    cost += 0.5 * (edges[i].robust ? std::min(chi2[i], max_chi2) : chi2[i]);
  }
  return cost;
}

double WorstRobust(absl::Span<const PoseGraphEdge> edges, const std::vector<double>& chi2) {
  double worst = 0;
  for (size_t i = 0; i < edges.size(); ++i) {
    if (edges[i].robust) worst = std::max(worst, chi2[i]);
  }
  return worst;
}

// True if any robust edge's weight changed.
bool UpdateWeights(absl::Span<const PoseGraphEdge> edges, const std::vector<double>& chi2,
                   const GraduatedTruncation& truncation, std::vector<AdjustableWeight>& weights) {
  bool changed = false;
  for (size_t i = 0; i < edges.size(); ++i) {
    if (!edges[i].robust) continue;
    const double weight = std::max(kLeastWeight, truncation.Weight(chi2[i]));
    changed |= weight != weights[i].value();
    weights[i].set_value(weight);
  }
  return changed;
}

// Algorithm 1 of Yang et al.: solve with all weights 1, then weigh and solve in turn while the
// truncation sharpens.
absl::Status SolveGraduated(const PoseGraphOptions& options, absl::Span<const PoseGraphEdge> edges,
                            const Blocks& blocks, std::vector<AdjustableWeight>& weights,
                            ceres::Problem& problem, PoseGraphResult& result) {
  RETURN_IF_ERROR(Solve(options, problem, result));
  std::vector<double> chi2 = EdgeChi2(edges, blocks, options.fix_scale);
  const double max_chi2 = MaxChi2(options);
  const double worst = WorstRobust(edges, chi2);
  if (worst <= max_chi2) return absl::OkStatus();
  GraduatedTruncation truncation(max_chi2, worst);
  for (int round = 0; round < kMaxRounds; ++round) {
    // Weights between 0 and 1 change with the truncation: those that don't are all decided.
    if (!UpdateWeights(edges, chi2, truncation, weights)) break;
    RETURN_IF_ERROR(Solve(options, problem, result));
    chi2 = EdgeChi2(edges, blocks, options.fix_scale);
    truncation.Sharpen();
  }
  return absl::OkStatus();
}

PoseGraphEdge PresentEdge(const Map& map, KeyframeId a, KeyframeId b) {
  const Rigid3d b_from_a =
      map.FindKeyframe(b)->camera_from_map * map.FindKeyframe(a)->camera_from_map.Inverse();
  return {a, b, Similarity3d::FromRigid(b_from_a), 1, false};
}

}  // namespace

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
  Blocks blocks;
  for (const auto& [id, pose] : initial) blocks[id] = ToBlock(pose);
  std::vector<AdjustableWeight> weights(edges.size());
  ceres::Problem::Options problem_options;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  if (options.fix_scale) {
    AddEdges<6>(measured, fixed, weights, blocks, problem);
  } else {
    AddEdges<7>(measured, fixed, weights, blocks, problem);
  }
  PoseGraphResult result;
  const auto cost = [&] {
    result.edge_chi2 = EdgeChi2(measured, blocks, options.fix_scale);
    return TruncatedCost(measured, result.edge_chi2, MaxChi2(options));
  };
  result.initial_cost = cost();
  RETURN_IF_ERROR(SolveGraduated(options, measured, blocks, weights, problem, result));
  result.final_cost = cost();
  for (const auto& [id, block] : blocks) {
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
  for (const auto& [a, b] : pairs) edges.push_back(PresentEdge(map, a, b));
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
