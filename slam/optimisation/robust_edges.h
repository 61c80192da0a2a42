// Decides which robust edges of a pose graph are believed.
#ifndef CORBSLAM_SLAM_OPTIMISATION_ROBUST_EDGES_H_
#define CORBSLAM_SLAM_OPTIMISATION_ROBUST_EDGES_H_

#include "absl/status/status.h"
#include "slam/optimisation/pose_graph_problem.h"

namespace corbslam {

// Solves with all robust edges; where some disagree beyond max_chi2, decides between them by
// graduated non-convexity with truncated least squares (Yang et al., RA-L 2020, algorithm 1). That
// may end beside the least truncated cost, when wrong edges that agree with each other win while
// all still have a say. So each edge that lost then gets a second chance: it is supposed to be
// right, the others are decided again under it, and what costs less stays (docs/adr/0006).
absl::Status SolveRobustly(PoseGraphProblem& problem);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_ROBUST_EDGES_H_
