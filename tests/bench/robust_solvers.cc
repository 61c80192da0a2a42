#include "tests/bench/robust_solvers.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "slam/util/status_macros.h"
#include "tests/bench/pairwise_consistency.h"

namespace corbslam::tests {
namespace {

// 95 % bound of chi2 with six degrees of freedom, which OptimisePoseGraph has, too.
constexpr double kMaxChi2 = 12.592;
// A switched-off edge still holds the graph together.
constexpr double kLeastWeight = 1e-9;
constexpr int kMaxRounds = 100;
constexpr double kGraduation = 1.4;
constexpr double kConverged = 1e-5;

using Weights = std::vector<double>;

// Solves from `initial`, with each overlap's weight multiplied; edge_chi2 is that of the overlaps,
// unmultiplied.
absl::StatusOr<PoseGraphResult> SolveWeighted(const AliasedGraph& graph,
                                              const std::map<KeyframeId, Similarity3d>& initial,
                                              const Weights& weights) {
  std::vector<PoseGraphEdge> edges = graph.odometry;
  for (size_t i = 0; i < weights.size(); ++i) {
    edges.push_back(graph.overlaps[i]);
    edges.back().weight *= std::max(weights[i], kLeastWeight);
    edges.back().robust = false;
  }
  ASSIGN_OR_RETURN(PoseGraphResult result, OptimisePoseGraph(initial, edges, graph.fixed, {}));
  result.edge_chi2.erase(result.edge_chi2.begin(),
                         result.edge_chi2.begin() + static_cast<ptrdiff_t>(graph.odometry.size()));
  for (size_t i = 0; i < weights.size(); ++i) {
    result.edge_chi2[i] /= std::max(weights[i], kLeastWeight);
  }
  return result;
}

absl::StatusOr<PoseGraphResult> SolveLeastSquares(const AliasedGraph& graph) {
  return SolveWeighted(graph, graph.initial, Weights(graph.overlaps.size(), 1.0));
}

double LargestChange(const Weights& a, const Weights& b) {
  double change = 0;
  for (size_t i = 0; i < a.size(); ++i) change = std::max(change, std::abs(a[i] - b[i]));
  return change;
}

absl::StatusOr<PoseGraphResult> SolveHuber(const AliasedGraph& graph) {
  Weights weights(graph.overlaps.size(), 1.0);
  ASSIGN_OR_RETURN(PoseGraphResult result, SolveLeastSquares(graph));
  for (int round = 0; round < kMaxRounds; ++round) {
    Weights next = weights;
    for (size_t i = 0; i < next.size(); ++i) {
      next[i] = std::min(1.0, std::sqrt(kMaxChi2 / std::max(result.edge_chi2[i], 1e-12)));
    }
    const double change = LargestChange(weights, next);
    weights = std::move(next);
    ASSIGN_OR_RETURN(result, SolveWeighted(graph, result.camera_from_map, weights));
    if (change < 1e-3) break;
  }
  return result;
}

absl::StatusOr<PoseGraphResult> SolveShipped(const AliasedGraph& graph) {
  std::vector<PoseGraphEdge> edges = graph.odometry;
  edges.insert(edges.end(), graph.overlaps.begin(), graph.overlaps.end());
  ASSIGN_OR_RETURN(PoseGraphResult result,
                   OptimisePoseGraph(graph.initial, edges, graph.fixed, {}));
  result.edge_chi2.erase(result.edge_chi2.begin(),
                         result.edge_chi2.begin() + static_cast<ptrdiff_t>(graph.odometry.size()));
  return result;
}

// The losses of Yang et al. say how convex to begin, what comes next, and the weight of a squared
// residual (their equations 12 and 14).
struct GemanMcClure {
  static double FirstMu(double worst_chi2) { return std::max(1.0, 2 * worst_chi2 / kMaxChi2); }
  static double NextMu(double mu) { return std::max(1.0, mu / kGraduation); }
  static bool IsLast(double mu) { return mu <= 1; }
  static double Weight(double chi2, double mu) {
    const double root = mu * kMaxChi2 / (chi2 + mu * kMaxChi2);
    return root * root;
  }
};

struct TruncatedLeastSquares {
  static double FirstMu(double worst_chi2) {
    return kMaxChi2 / std::max(2 * worst_chi2 - kMaxChi2, 1e-9);
  }
  static double NextMu(double mu) { return mu * kGraduation; }
  static bool IsLast(double mu) { return mu > 1e4; }
  static double Weight(double chi2, double mu) {
    if (chi2 <= mu / (mu + 1) * kMaxChi2) return 1;
    if (chi2 >= (mu + 1) / mu * kMaxChi2) return 0;
    return std::sqrt(kMaxChi2 * mu * (mu + 1) / chi2) - mu;
  }
};

// Runs algorithm 1 of Yang et al. from `result` on, which gives the first residuals.
template <typename Loss>
absl::StatusOr<PoseGraphResult> Graduate(const AliasedGraph& graph, PoseGraphResult result) {
  const auto worst = std::max_element(result.edge_chi2.begin(), result.edge_chi2.end());
  if (worst == result.edge_chi2.end()) return result;
  double mu = Loss::FirstMu(*worst);
  double cost = INFINITY;
  for (int round = 0; round < kMaxRounds; ++round) {
    Weights weights;
    for (const double chi2 : result.edge_chi2) weights.push_back(Loss::Weight(chi2, mu));
    ASSIGN_OR_RETURN(result, SolveWeighted(graph, result.camera_from_map, weights));
    const bool converged = std::abs(cost - result.final_cost) < kConverged * result.final_cost;
    cost = result.final_cost;
    if (Loss::IsLast(mu) && converged) break;
    mu = Loss::NextMu(mu);
  }
  return result;
}

// Begins as the paper does: the first residuals are those of least squares on all.
template <typename Loss>
absl::StatusOr<PoseGraphResult> SolveGnc(const AliasedGraph& graph) {
  ASSIGN_OR_RETURN(PoseGraphResult first, SolveLeastSquares(graph));
  return Graduate<Loss>(graph, std::move(first));
}

// Begins as Kimera-Multi does (Tian et al., T-RO 2022, section V.B): the first residuals are those
// of the maps as they were placed.
template <typename Loss>
absl::StatusOr<PoseGraphResult> SolvePlacedGnc(const AliasedGraph& graph) {
  ASSIGN_OR_RETURN(PoseGraphResult first,
                   SolveWeighted(graph, graph.initial, Weights(graph.overlaps.size(), 0.0)));
  return Graduate<Loss>(graph, std::move(first));
}

absl::StatusOr<PoseGraphResult> SolveConsistent(const AliasedGraph& graph) {
  return SolveWeighted(graph, graph.initial, ConsistentOverlaps(graph));
}

}  // namespace

const std::vector<RobustSolver>& RobustSolvers() {
  static const auto* const solvers =
      new std::vector<RobustSolver>{{"least squares", SolveLeastSquares},
                                    {"Huber", SolveHuber},
                                    {"shipped", SolveShipped},
                                    {"GNC-GM", SolveGnc<GemanMcClure>},
                                    {"GNC-TLS", SolveGnc<TruncatedLeastSquares>},
                                    {"placed GNC-TLS", SolvePlacedGnc<TruncatedLeastSquares>},
                                    {"PCM", SolveConsistent}};
  return *solvers;
}

absl::StatusOr<PoseGraphResult> SolveClean(const AliasedGraph& graph) {
  Weights weights;
  for (const bool is_wrong : graph.is_wrong) weights.push_back(is_wrong ? 0 : 1);
  return SolveWeighted(graph, graph.initial, weights);
}

}  // namespace corbslam::tests
