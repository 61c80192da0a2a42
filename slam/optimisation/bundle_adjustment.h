// Adjusts part or all of a map: poses and points that minimise the robust reprojection error.
#ifndef CORBSLAM_SLAM_OPTIMISATION_BUNDLE_ADJUSTMENT_H_
#define CORBSLAM_SLAM_OPTIMISATION_BUNDLE_ADJUSTMENT_H_

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/map.h"
#include "slam/optimisation/bundle_scope.h"
#include "slam/util/ids.h"

namespace corbslam {

enum class BundleSolver {
  // Our own solver; several times as fast at every size measured.
  kBlockSchur,
  // Ceres, with SuiteSparse where there are many keyframes; it is the reference.
  kCeres,
};

struct BundleOptions {
  // Iterations of each round: there are outlier_rounds + 1 of them, the last ones shorter where
  // converged.
  int max_iterations = 10;
  // Huber's loss, at the 95 % bound of chi2 (5.991 monocular, 7.815 stereo). It is off after the
  // first rejection of outliers. What is off by more than ten times the bound pulls at nothing
  // either way (ObservationLoss).
  bool use_robust_loss = true;
  // After each such round observations beyond the bound (or behind the camera) are left out, and
  // those left out before may come back; then the next round goes on.
  int outlier_rounds = 1;
  // The bound after the first round is of the noise that is measured then, not of the assumed
  // pixel (measurement_noise.h). What the result names as outliers is by the assumed one all the
  // same: what is left out here says little, but is no false match.
  bool measure_noise = false;
  // Solver threads. With one, the same input gives the same bits every time.
  int threads = 1;
  // Called after every iteration with the part done, in [0, 1]; false cancels. It may be null.
  std::function<bool(double progress)> keep_going;
  // Both find the same minimum; docs/adr/0002-bundle-adjustment-solver.md says which is for what.
  BundleSolver solver = BundleSolver::kBlockSchur;
  // The last round ends where an iteration changes the cost by less than this share of it, those
  // before, which only have to tell outliers, by less than that.
  double converged_cost_change = 1e-5;
  double outlier_round_cost_change = 1e-5;
};

struct PoseUpdate {
  KeyframeId id;
  Rigid3d camera_from_map;
};

struct PositionUpdate {
  MapPointId id;
  Eigen::Vector3d position_in_map;
};

struct ObservationKey {
  MapPointId point;
  KeyframeId keyframe;
  friend auto operator<=>(const ObservationKey&, const ObservationKey&) = default;
};

struct BundleResult {
  // The free keyframes, in the scope's order.
  std::vector<PoseUpdate> poses;
  // The free points, in the scope's order, except those no observation constrains.
  std::vector<PositionUpdate> positions;
  // Observations between the scope's items beyond the bound at the result, sorted. A monocular
  // observation has two degrees of freedom, one with disparity three.
  std::vector<ObservationKey> outliers;
  int iterations = 0;
  // The robust cost before the first round, and the cost after the last.
  double initial_cost = 0;
  double final_cost = 0;
  // True: the result is the best so far and still consistent.
  bool cancelled = false;
};

// Reads `map` and changes nothing. Only observations between the scope's keyframes and points
// count. Where nothing measures a depth and one keyframe alone is fixed the result is as large as
// the map was (scale_gauge.h). INVALID_ARGUMENT, naming the id, where the scope names an unknown or
// repeated item, or nothing is free or nothing observed; FAILED_PRECONDITION where no keyframe is
// fixed; INTERNAL where Ceres fails. Pure; any thread.
absl::StatusOr<BundleResult> AdjustBundle(const Map& map, const BundleScope& scope,
                                          const BundleOptions& options);

// Sets poses and positions and removes the outlier observations. Items that are gone meanwhile are
// skipped. Geometry of the moved points (normal, distance range) is brought up to date.
void ApplyBundle(const BundleResult& result, Map& map);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_BUNDLE_ADJUSTMENT_H_
