// A landmark: its position, what it looks like and which keypoints see it.
#ifndef CORBSLAM_SLAM_MAP_MAP_POINT_H_
#define CORBSLAM_SLAM_MAP_MAP_POINT_H_

#include <Eigen/Core>
#include <cstdint>

#include "absl/container/btree_map.h"
#include "slam/features/keypoint.h"
#include "slam/util/ids.h"

namespace corbslam {

struct MapPoint {
  MapPointId id;
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
  // The keyframe that the point follows when only keyframes move.
  KeyframeId reference;
  // The observing descriptor that has the least median distance to the others.
  Descriptor descriptor;
  // Mean unit direction from the observing cameras to the point.
  Eigen::Vector3d normal_in_map = Eigen::Vector3d::Zero();
  // Distances from which the point is expected to be found on the pyramid.
  double min_distance = 0;
  double max_distance = 0;
  // Index of the point's keypoint in each keyframe; a keyframe has one keypoint of it at most.
  absl::btree_map<KeyframeId, uint32_t> observations;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MAP_MAP_POINT_H_
