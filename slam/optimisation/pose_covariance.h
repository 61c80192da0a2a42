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
// (translation, rotation) of `camera_from_map` on the left, metres and radians. It is H^-1 G H^-1
// with the information matrix H = J^T W J, and G the sum over the picture's cells of the squares of
// their J^T W r: the covariance that is right for residuals of any size that neighbours share
// (Liang and Zeger, "Longitudinal data analysis using generalized linear models", 1986), as corners
// have that are found at several scales or lie on one edge. Where few cells have observations, H^-1
// scaled by the noise that the residuals show. The points are taken as they are: the map's own
// errors are not in it. Returns nullopt where the observations don't determine the pose. Pure; any
// thread.
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
