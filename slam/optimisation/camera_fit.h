// Asks whether a picture fits known points better with another camera than with the one that is
// said to have taken it: one of another focal length, principal point or lens, or of a pair that
// stands otherwise apart.
#ifndef CORBSLAM_SLAM_OPTIMISATION_CAMERA_FIT_H_
#define CORBSLAM_SLAM_OPTIMISATION_CAMERA_FIT_H_

#include <Eigen/Core>
#include <optional>

#include "absl/types/span.h"
#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"
#include "slam/optimisation/pose_optimisation.h"

namespace corbslam {

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
  // Without `radial`.
  Camera camera;
};

// The fit begins at the pose that the given camera has. Nullopt where the points don't determine a
// camera: few, in a plane that it looks at, or all far. The observations' disparities take no part
// in any number but their own. Pure.
std::optional<CameraFit> FitCamera(const Camera& camera, const Rigid3d& camera_from_map,
                                   absl::Span<const PoseObservation> observations);

// Whether the fitted camera is another one beyond doubt, and beyond what a fair calibration may be
// off: 1.5 % of the focal length, 2.5 % between fx and fy and of the sides, 1 % of half
// the width at its edge for the lens, 6 % of disparities.
bool IsAnotherCamera(const CameraFit& fit);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_CAMERA_FIT_H_
