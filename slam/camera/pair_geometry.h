// Where the pictures of a rectified pair come from, whatever its lenses.
#ifndef CORBSLAM_SLAM_CAMERA_PAIR_GEOMETRY_H_
#define CORBSLAM_SLAM_CAMERA_PAIR_GEOMETRY_H_

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "absl/status/statusor.h"
#include "slam/camera/camera.h"
#include "slam/camera/lens.h"
#include "slam/camera/rectification.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

struct PairRotations {
  Eigen::Quaterniond rectified_from_left;
  Eigen::Quaterniond rectified_from_right;
};

// Returns Bouguet's rotations: each camera turns by half of what lies between them, then both turn,
// by as little as they must, until the right one lies along +x of the left one.
PairRotations RotationsOf(const Rigid3d& right_from_left);

// Returns the pinhole of the raw pictures' size, with its axis in their middle and square pixels,
// that shows most: no pixel from outside either raw picture, and no more than widest_field_deg from
// left to right. INVALID_ARGUMENT where even a narrow one of 20 degrees sees beyond them: then the
// cameras look in different directions, or the principal points are of other pictures.
absl::StatusOr<Camera> WidestPinhole(const RawStereo& raw, const PairRotations& rotations);

// Returns for each pixel of `camera`'s pictures (CV_32FC2, x and y) where it is in the raw ones.
// INVALID_ARGUMENT, naming the pixel, where the lens doesn't see it.
absl::StatusOr<cv::Mat> SourcePixels(const Camera& camera,
                                     const Eigen::Quaterniond& rectified_from_raw,
                                     const RawCamera& raw);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CAMERA_PAIR_GEOMETRY_H_
