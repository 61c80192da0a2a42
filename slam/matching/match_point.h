// What matching needs of a map point, as a value: it may be used while the map changes.
#ifndef CORBSLAM_SLAM_MATCHING_MATCH_POINT_H_
#define CORBSLAM_SLAM_MATCHING_MATCH_POINT_H_

#include <Eigen/Core>
#include <optional>

#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/map_point.h"
#include "slam/util/ids.h"

namespace corbslam {

struct MatchPoint {
  MapPointId id;
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_in_map = Eigen::Vector3d::Zero();
  double min_distance = 0;
  double max_distance = 0;
  Descriptor descriptor;
};

MatchPoint MakeMatchPoint(const MapPoint& point);

// Says where and how a point should appear in an image.
struct PredictedView {
  Eigen::Vector2d pixel;
  double disparity_px = 0;  // 0: the camera has no baseline.
  int octave = 0;
  // Cosine of the angle between the line of sight and the mean direction from which the point was
  // seen.
  double view_cosine = 1;
};

// Returns none where the point is behind the camera, outside the image, seen from a distance at
// which it would not be found (20 % of tolerance), or from more than 60 degrees off its mean
// direction (ORB-SLAM, Mur-Artal et al., T-RO 2015, V.D).
std::optional<PredictedView> PredictView(const MatchPoint& point, const Camera& camera,
                                         const Rigid3d& camera_from_map);
std::optional<PredictedView> PredictView(const MapPoint& point, const Camera& camera,
                                         const Rigid3d& camera_from_map);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MATCHING_MATCH_POINT_H_
