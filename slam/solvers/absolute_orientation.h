// Aligns two sets of points by a similarity in closed form.
#ifndef CORBSLAM_SLAM_SOLVERS_ABSOLUTE_ORIENTATION_H_
#define CORBSLAM_SLAM_SOLVERS_ABSOLUTE_ORIENTATION_H_

#include <Eigen/Core>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// Returns the b_from_a that minimises the sum of |x_b - b_from_a * x_a|^2, by the unit quaternion
// that is an eigenvector; the scale is the symmetric one, or 1 where `fix_scale`. INVALID_ARGUMENT
// where the sizes differ, there are fewer than 3 points, they lie on a line or are not finite.
// Source: Horn, "Closed-form solution of absolute orientation using unit quaternions", JOSA A 1987.
absl::StatusOr<Similarity3d> AlignPoints(absl::Span<const Eigen::Vector3d> points_a,
                                         absl::Span<const Eigen::Vector3d> points_b,
                                         bool fix_scale);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SOLVERS_ABSOLUTE_ORIENTATION_H_
