// Solves pose graphs of which some overlaps are wrong in several ways, for comparison with what is
// shipped.
#ifndef CORBSLAM_TESTS_BENCH_ROBUST_SOLVERS_H_
#define CORBSLAM_TESTS_BENCH_ROBUST_SOLVERS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/optimisation/pose_graph.h"
#include "tests/bench/aliased_graph.h"

namespace corbslam::tests {

struct RobustSolver {
  std::string name;
  // Returns poses, and weight * |residual|^2 of each overlap after solving.
  absl::StatusOr<PoseGraphResult> (*solve)(const AliasedGraph& graph);
};

// Returns these solvers: least squares; Huber's loss by iteratively reweighted least squares;
// OptimisePoseGraph with robust edges, as shipped; graduated non-convexity with the losses of Geman
// and McClure and of truncated least squares (Yang et al., "Graduated Non-Convexity for Robust
// Spatial Perception", RA-L 2020, algorithm 1); pairwise consistency maximisation before least
// squares (Mangelson et al., "Pairwise Consistent Measurement Set Maximization", ICRA 2018).
const std::vector<RobustSolver>& RobustSolvers();

// Solves what a solver is measured against: least squares on the true overlaps alone.
absl::StatusOr<PoseGraphResult> SolveClean(const AliasedGraph& graph);

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_ROBUST_SOLVERS_H_
