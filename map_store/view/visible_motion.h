// Says which motions are worth telling whoever looks at the map: those that a keyframe which sees
// the place would show in its own picture. Who looks at a map is farther away than the robot was.
#ifndef CORBSLAM_MAP_STORE_VIEW_VISIBLE_MOTION_H_
#define CORBSLAM_MAP_STORE_VIEW_VISIBLE_MOTION_H_

#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"

namespace corbslam::map_store {

// Returns whether a camera that goes from `a` to `b` (both camera_from_island) moves what it sees
// close by by more than a pixel.
bool IsSeenToMove(const Similarity3d& a, const Similarity3d& b, const Camera& camera);

// Returns by how much a point at this place in the camera may be elsewhere without being seen to
// have moved by more than a pixel; in the camera's units.
double LeastVisibleMotion(const Eigen::Vector3d& position_in_camera, const Camera& camera);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_VISIBLE_MOTION_H_
