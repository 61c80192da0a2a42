// Long drives of which only poses matter: a keyframe a metre, straight ahead along x.
#ifndef CORBSLAM_SLAM_FUSING_TESTING_LONG_DRIVE_H_
#define CORBSLAM_SLAM_FUSING_TESTING_LONG_DRIVE_H_

#include "slam/exchange/overlap.h"
#include "slam/map/map.h"

namespace corbslam::testing {

// Adds keyframes 0 to `count` - 1, in a chain, from x = `start` on. With `depth_m` above 0 each
// sees a point of its own that far away.
void AddDrive(LocalMapId id, uint32_t start, uint32_t count, double depth_m, Map& map);

// Makes an accepted overlap of two keyframes, which says where they are in the map but for an
// error.
Overlap SayOverlap(const Map& map, KeyframeId query, KeyframeId candidate,
                   const Eigen::Vector3d& wrong_by, double turned_by_rad = 0);

}  // namespace corbslam::testing

#endif  // CORBSLAM_SLAM_FUSING_TESTING_LONG_DRIVE_H_
