// Optimises poses by Ceres' TinySolver: OptimisePose is measured against it.
#ifndef CORBSLAM_SLAM_OPTIMISATION_TESTING_TINY_POSE_SOLVER_H_
#define CORBSLAM_SLAM_OPTIMISATION_TESTING_TINY_POSE_SOLVER_H_

#include <Eigen/Core>
#include <vector>

#include "absl/types/span.h"
#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"
#include "slam/optimisation/pose_optimisation.h"
#include "slam/optimisation/reprojection.h"

namespace corbslam::testing {

struct PoseMeasurement {
  // Position under the pose about which the cost function's parameters are.
  Eigen::Vector3d x_in_base;
  PixelMeasurement pixel;
};

// A cost for TinySolver: six parameters (translation, rotation vector) move x_in_base to
// Exp(rotation) x_in_base + translation in the camera; each measurement has three residuals, the
// third 0 without depth. TinySolver knows no losses, so each residual is scaled to have Huber's
// cost.
struct TinyPoseCost {
  using Scalar = double;
  enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = 6 };

  Camera camera;
  std::vector<PoseMeasurement> measurements;
  bool robust = true;

  int NumResiduals() const { return 3 * static_cast<int>(measurements.size()); }
  // `jacobian` is in column-major order; may be null.
  bool operator()(const double* parameters, double* residuals, double* jacobian) const;
};

// Has the same rounds, bounds and result as OptimisePose.
PoseEstimate OptimisePoseTiny(const Camera& camera, const Rigid3d& initial_camera_from_map,
                              absl::Span<const PoseObservation> observations);

}  // namespace corbslam::testing

#endif  // CORBSLAM_SLAM_OPTIMISATION_TESTING_TINY_POSE_SOLVER_H_
