#include "slam/optimisation/pose_graph_problem.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "slam/optimisation/relative_pose_cost.h"

namespace corbslam {
namespace {

// 95 % bounds of chi2 with six and seven degrees of freedom.
constexpr double kChi2Rigid = 12.592;
constexpr double kChi2Similarity = 14.067;

ceres::Problem::Options ProblemOptions() {
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

ceres::Solver::Options SolverOptions(const PoseGraphOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = options.threads;
  solver.logging_type = ceres::SILENT;
  // The graph begins near its minimum, so the first Gauss-Newton step is trusted.
  solver.initial_trust_region_radius = 1e16;
  return solver;
}

}  // namespace

PoseGraphProblem::PoseGraphProblem(const std::map<KeyframeId, Similarity3d>& initial,
                                   absl::Span<const PoseGraphEdge> edges,
                                   const absl::btree_set<KeyframeId>& fixed,
                                   const PoseGraphOptions& options)
    : edges_(edges), options_(options), weights_(edges.size()), problem_(ProblemOptions()) {
  for (const auto& [id, pose] : initial) blocks_[id] = ToBlock(pose);
  for (size_t i = 0; i < edges.size(); ++i) {
    if (edges[i].robust) robust_.push_back(i);
  }
  if (options.fix_scale) {
    AddEdges<6>(fixed);
  } else {
    AddEdges<7>(fixed);
  }
}

template <int kTangent>
void PoseGraphProblem::AddEdges(const absl::btree_set<KeyframeId>& fixed) {
  for (size_t i = 0; i < edges_.size(); ++i) {
    const PoseGraphEdge& edge = edges_[i];
    const Matrix7d R = std::sqrt(edge.weight) * edge.root_information;
    problem_.AddResidualBlock(new RelativePoseCost<kTangent>(edge.b_from_a, R),
                              edge.robust ? &weights_[i] : nullptr, blocks_.at(edge.a).data(),
                              blocks_.at(edge.b).data());
  }
  // The blocks share them; the problem deletes each once.
  ceres::Manifold* free = nullptr;
  ceres::Manifold* rigid = nullptr;
  for (auto& [id, block] : blocks_) {
    if (!problem_.HasParameterBlock(block.data())) continue;
    if (kTangent == 7 && options_.keep_scale.contains(id)) {
      if (rigid == nullptr) rigid = new LeftPerturbation<6>();
      problem_.SetManifold(block.data(), rigid);
    } else {
      if (free == nullptr) free = new LeftPerturbation<kTangent>();
      problem_.SetManifold(block.data(), free);
    }
    if (fixed.contains(id)) problem_.SetParameterBlockConstant(block.data());
  }
}

absl::Status PoseGraphProblem::Solve() {
  ceres::Solver::Summary summary;
  ceres::Solve(SolverOptions(options_), &problem_, &summary);
  if (!summary.IsSolutionUsable()) {
    return absl::InternalError(absl::StrCat("pose graph: ", summary.message));
  }
  iterations_ += static_cast<int>(summary.iterations.size());
  return absl::OkStatus();
}

bool PoseGraphProblem::SetWeight(size_t edge, double weight) {
  const bool changes = weight != weights_[edge].value();
  weights_[edge].set_value(weight);
  return changes;
}

void PoseGraphProblem::SetPoses(const Blocks& poses) {
  // The problem knows the blocks by their addresses.
  for (auto& [id, block] : blocks_) block = poses.at(id);
}

std::vector<double> PoseGraphProblem::EdgeChi2() const {
  std::vector<double> chi2;
  chi2.reserve(edges_.size());
  for (const PoseGraphEdge& edge : edges_) {
    Vector7d error = LogSim3(edge.b_from_a * FromBlock(blocks_.at(edge.a).data()) *
                             FromBlock(blocks_.at(edge.b).data()).Inverse());
    if (options_.fix_scale) error[6] = 0;
    chi2.push_back(edge.weight * (edge.root_information * error).squaredNorm());
  }
  return chi2;
}

double PoseGraphProblem::max_chi2() const {
  return options_.fix_scale ? kChi2Rigid : kChi2Similarity;
}

double PoseGraphProblem::TruncatedCost(const std::vector<double>& chi2) const {
  double cost = 0;
  for (size_t i = 0; i < edges_.size(); ++i) {
    cost += 0.5 * (edges_[i].robust ? std::min(chi2[i], max_chi2()) : chi2[i]);
  }
  return cost;
}

}  // namespace corbslam
