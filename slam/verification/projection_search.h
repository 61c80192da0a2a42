// Finds one map's points in another map's keyframe, given how the two stand to each other.
#ifndef CORBSLAM_SLAM_VERIFICATION_PROJECTION_SEARCH_H_
#define CORBSLAM_SLAM_VERIFICATION_PROJECTION_SEARCH_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slam/geometry/rigid3.h"
#include "slam/map/keyframe.h"
#include "slam/map/map_point.h"

namespace corbslam {

struct ProjectionSearchOptions {
  // Radius at the finest level; it grows with the level at which the point should appear.
  double radius_px = 5;
  int max_distance = 50;
  // True: only keypoints that observe a point are searched.
  bool only_keypoints_with_points = false;
  // Where a keypoint has a depth, the point's must agree within the same radius of disparity.
  bool check_disparity = true;
  // The search looks this many radii from where the points should be: what is found there is found
  // by chance.
  Eigen::Vector2d displacement_radii = Eigen::Vector2d::Zero();
};

struct ProjectionMatch {
  uint32_t point = 0;  // Index into the points that were given.
  uint32_t keypoint = 0;
  int distance = 0;  // Hamming distance.
};

// Finds each point and each keypoint at most once (the nearest descriptor wins, then the first
// point); the matches are sorted by keypoint. `camera_from_points` maps the frame of the points
// into the keyframe's camera with the points' own unit of length (Similarity3d::ToRigid). Points
// are left out that lie behind the camera, out of the picture, or far outside the range of
// distances or angles from which they were seen. Pure.
std::vector<ProjectionMatch> FindByProjection(const std::vector<const MapPoint*>& points,
                                              const Keyframe& keyframe,
                                              const Rigid3d& camera_from_points,
                                              const ProjectionSearchOptions& options);

// Returns the most of the points that FindByProjection finds right beside where they should be, on
// any of the four sides: so many match by chance. The options' displacement does not count.
size_t CountByChance(const std::vector<const MapPoint*>& points, const Keyframe& keyframe,
                     const Rigid3d& camera_from_points, ProjectionSearchOptions options);
// Returns the mean of the four sides, rounded up.
size_t MeanByChance(const std::vector<const MapPoint*>& points, const Keyframe& keyframe,
                    const Rigid3d& camera_from_points, ProjectionSearchOptions options);

// Returns how many of the points FindByProjection looks for: those that should be in the picture,
// seen from distances and angles like before. Whether something hides them is not asked.
size_t CountVisible(const std::vector<const MapPoint*>& points, const Keyframe& keyframe,
                    const Rigid3d& camera_from_points);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VERIFICATION_PROJECTION_SEARCH_H_
