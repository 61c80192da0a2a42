// Minimises bundle adjustments by Levenberg-Marquardt in blocks whose sizes the compiler knows.
#ifndef CORBSLAM_SLAM_OPTIMISATION_BLOCK_SCHUR_SOLVER_H_
#define CORBSLAM_SLAM_OPTIMISATION_BLOCK_SCHUR_SOLVER_H_

#include <memory>

#include "slam/optimisation/bundle_problem.h"

namespace corbslam {

// The points are eliminated first (Triggs et al., "Bundle Adjustment - A Modern Synthesis", 1999,
// 6.1). docs/adr/0002-bundle-adjustment-solver.md says when to use it. Not thread-safe.
class BlockSchurSolver {
 public:
  // The solver remembers what sees what in `problem`, which must outlive it and may change in all
  // else.
  BlockSchurSolver(int threads, BundleProblem& problem);
  ~BlockSchurSolver();

  // Moves the free poses and points by the observations that are used; the cost never rises. With
  // one thread the same calls give the same bits every time. options.threads says nothing.
  MinimiseSummary Minimise(const MinimiseOptions& options);

 private:
  class Equations;
  std::unique_ptr<Equations> equations_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_BLOCK_SCHUR_SOLVER_H_
