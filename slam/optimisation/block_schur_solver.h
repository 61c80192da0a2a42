// Levenberg-Marquardt for bundle adjustment in blocks whose sizes the compiler knows.
#ifndef CORBSLAM_SLAM_OPTIMISATION_BLOCK_SCHUR_SOLVER_H_
#define CORBSLAM_SLAM_OPTIMISATION_BLOCK_SCHUR_SOLVER_H_

#include "slam/optimisation/bundle_problem.h"

namespace corbslam {

// Moves the free poses and points of `problem`; its cost never rises. The points are eliminated
// first (Triggs et al., "Bundle Adjustment - A Modern Synthesis", 1999, 6.1). One thread gives the
// same bits every time. When to use it: docs/adr/0002-bundle-adjustment-solver.md.
MinimiseSummary MinimiseWithBlockSchur(const MinimiseOptions& options, BundleProblem& problem);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_BLOCK_SCHUR_SOLVER_H_
