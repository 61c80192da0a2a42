// Says how well a frame's points determine its pose.
#ifndef CORBSLAM_SLAM_OPTIMISATION_POSE_COVARIANCE_H_
#define CORBSLAM_SLAM_OPTIMISATION_POSE_COVARIANCE_H_

#include <optional>

#include "absl/types/span.h"
#include "slam/camera/camera.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/optimisation/pose_optimisation.h"

namespace corbslam {

// Returns the covariance of a pose that OptimisePose found, of its inliers: of a perturbation
// (translation, rotation) of `camera_from_map` on the left, metres and radians. It is the inverse
// of the information matrix J^T W J, with the assumed variances scaled by the noise that the
// residuals show (the a-posteriori variance factor, chi2 by degrees of freedom: Triggs et al.,
// "Bundle Adjustment - A Modern Synthesis", 2000). The points are taken as they are: errors that
// they share are not in it. Returns nullopt where the observations don't determine the pose. Pure;
// any thread.
std::optional<Matrix6d> PoseCovariance(const Camera& camera, const Rigid3d& camera_from_map,
                                       absl::Span<const PoseObservation> inliers);

// Returns the covariance of the camera's pose in the map from that of PoseCovariance: of its
// position along and its rotation about the map's axes (on the left of map_from_camera's rotation).
Matrix6d InMapAxes(const Rigid3d& camera_from_map, const Matrix6d& covariance);

// Returns the covariance of another frame's pose that is fixed to the camera, from the one that
// InMapAxes gives.
Matrix6d OfAttachedFrame(const Rigid3d& map_from_camera, const Rigid3d& camera_from_attached,
                         const Matrix6d& covariance_in_map_axes);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_OPTIMISATION_POSE_COVARIANCE_H_
