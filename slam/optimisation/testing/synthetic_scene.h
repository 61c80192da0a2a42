// Makes seeded synthetic scenes with known truth, as maps, for tests and benchmarks.
#ifndef CORBSLAM_SLAM_OPTIMISATION_TESTING_SYNTHETIC_SCENE_H_
#define CORBSLAM_SLAM_OPTIMISATION_TESTING_SYNTHETIC_SCENE_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/map.h"
#include "slam/util/ids.h"

namespace corbslam::testing {

struct SyntheticSceneOptions {
  uint64_t seed = 1;
  LocalMapId local_map = {0x5ce7e};
  int keyframes = 10;
  int points = 500;
  // Keyframes follow each other along x, looking along z, with slight turns; the points fill a
  // box in front of the whole way.
  double step_m = 0.5;
  double nearest_m = 4;
  double farthest_m = 20;
  // A point is kept only in so many keyframes, one after the other; 0: in all that see it.
  int max_observations_per_point = 0;
  // Share of observations that get a disparity.
  double share_with_depth = 1;
  double pixel_noise_px = 0;
  // Share of observations whose pixel is moved by 20 to 60 px.
  double share_of_outliers = 0;
  // Share of disparities that are 1.5 to 2 px of the octave too small, as where what is behind an
  // edge was measured; these are not among the scene's outliers.
  double share_of_false_depths = 0;
  // Noise of poses and positions of the map (the root's pose has none).
  double pose_noise_m = 0;
  double pose_noise_rad = 0;
  double point_noise_m = 0;
};

struct SyntheticScene {
  Camera camera;
  Map map;
  std::map<KeyframeId, Rigid3d> true_camera_from_map;
  std::map<MapPointId, Eigen::Vector3d> true_position_in_map;
  // The false observations in the map, sorted.
  std::vector<std::pair<MapPointId, KeyframeId>> outliers;
};

// Returns a camera of 752 x 480 px, f = 458 px and baseline 0.11 m.
Camera SyntheticCamera();

// Makes keyframes 0 to keyframes - 1 (0 is the root, each hangs on the one before), points seen by
// at least two keyframes, random descriptors (nearly equal for one point), and octaves by distance.
SyntheticScene MakeSyntheticScene(const SyntheticSceneOptions& options);

size_t CountObservations(const Map& map);

}  // namespace corbslam::testing

#endif  // CORBSLAM_SLAM_OPTIMISATION_TESTING_SYNTHETIC_SCENE_H_
