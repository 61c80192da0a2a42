// Adjusts bundles by Ceres, with SuiteSparse where there are many poses.
#ifndef CORBSLAM_SLAM_OPTIMISATION_CERES_BUNDLE_SOLVER_H_
#define CORBSLAM_SLAM_OPTIMISATION_CERES_BUNDLE_SOLVER_H_

#include "absl/status/statusor.h"
#include "slam/optimisation/bundle_problem.h"

namespace corbslam {

// Moves the free poses and points of `problem`; its cost never rises. The points are eliminated
// first; the poses' equations are solved densely where they are few, else by CHOLMOD. One thread
// gives the same bits every time. INTERNAL, with `problem` as it was, where Ceres fails, as it does
// where a residual is not finite. docs/adr/0002-bundle-adjustment-solver.md says when to use it.
absl::StatusOr<MinimiseSummary> MinimiseWithCeres(const MinimiseOptions& options,
                                                  BundleProblem& problem);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_CERES_BUNDLE_SOLVER_H_
