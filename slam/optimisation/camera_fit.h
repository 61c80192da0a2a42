// Asks with which camera a picture fits known points best, and how far the points tell: one that is
// said to have taken it may have another focal length, principal point or lens, or be of a pair
// that stands otherwise apart.
#ifndef CORBSLAM_SLAM_OPTIMISATION_CAMERA_FIT_H_
#define CORBSLAM_SLAM_OPTIMISATION_CAMERA_FIT_H_

#include <Eigen/Core>
#include <optional>

#include "absl/types/span.h"
#include "slam/camera/camera.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/optimisation/pose_optimisation.h"

namespace corbslam {

// A pinhole with what a lens does to it, k1, k2, p1 and p2 of Brown's model (Decentering distortion
// of lenses, 1966), in focal lengths. A lens that was undone about another centre is left
// decentred.
struct BentCamera {
  Camera camera;
  double k1 = 0;
  double k2 = 0;
  double p1 = 0;
  double p2 = 0;

  // The depth must be positive.
  Eigen::Vector2d Project(const Eigen::Vector3d& x_in_camera) const;
  // Returns where the pinhole alone would have a pixel; where the lens folds back, the pixel
  // itself.
  Eigen::Vector2d Straighten(const Eigen::Vector2d& pixel) const;
};

// A quantity of the camera, and its standard deviation.
struct FittedNumber {
  double value = 0;
  double sigma = 0;
};

// The camera with which the points agree best, by what it differs from the given one.
struct CameraFit {
  FittedNumber focal;     // Natural logarithm of fitted over given focal length.
  FittedNumber aspect;    // Of fy's, less that of fx's.
  FittedNumber centre_x;  // Fitted less given, in shares of the width.
  FittedNumber centre_y;  // Of the height.
  FittedNumber radial;    // What the lens moves half a width from the centre, in shares of that.
  // Natural logarithm of measured disparities over those that the points should have; 0 and
  // infinitely unsure where there are none.
  FittedNumber disparity;
  Rigid3d camera_from_map;
  // The covariance of a perturbation (translation, rotation) on the left of camera_from_map, for
  // somebody who knows no more of the camera than that it is one.
  Matrix6d pose_covariance;
  BentCamera bent;
  // The bent camera without its lens, and with the baseline that the disparities have.
  Camera camera;
};

struct CameraFitOptions {
  // The fit begins with this camera; nullopt: with the given one.
  std::optional<BentCamera> start = {};
  // Pixels at the finest level beyond which an observation counts ever less; it shrinks from here
  // to what noise is. 0: all of them are taken to be right.
  double first_scale_px = 0;
};

// The fit begins at a pose, as a rule that which the given camera has. Nullopt where observations
// are few. Where they don't determine a number its sigma is large: as large as cameras differ. The
// observations' disparities take no part in any number but their own. Pure.
std::optional<CameraFit> FitCamera(const Camera& camera, const Rigid3d& camera_from_map,
                                   absl::Span<const PoseObservation> observations,
                                   const CameraFitOptions& options = {});

// Returns the covariance of a pose that was found with the given camera, of the observations that
// `fit` is of: a perturbation of it on the left, as pose_covariance, and how far it is from where
// the fitted camera has it.
Matrix6d CovarianceOfAnyCamera(const CameraFit& fit, const Rigid3d& camera_from_map);

// Whether the fitted camera is another one beyond doubt, and by more than what its pose's
// covariance is to bear: 4 % of the focal length, between fx and fy and of the sides, 3 % of half
// the width at its edge for the lens, 8 % of disparities.
bool IsAnotherCamera(const CameraFit& fit);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_CAMERA_FIT_H_
