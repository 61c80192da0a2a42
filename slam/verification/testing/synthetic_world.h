// A world of points with unique descriptors, and local maps of it with known truth: for tests of
// verification, fusing and loop closing.
#ifndef CORBSLAM_SLAM_VERIFICATION_TESTING_SYNTHETIC_WORLD_H_
#define CORBSLAM_SLAM_VERIFICATION_TESTING_SYNTHETIC_WORLD_H_

#include <cstdint>
#include <map>
#include <vector>

#include "slam/map/map.h"

namespace corbslam::testing {

struct SyntheticWorld {
  std::vector<Eigen::Vector3d> positions_m;
  std::vector<Descriptor> descriptors;
};

inline constexpr double kRingRadius_m = 15;

// Makes points in a ring 8 m wide and 6 m high around a circle (y points down).
SyntheticWorld MakeRingWorld(uint64_t seed, int points = 6000, double radius_m = kRingRadius_m);

// Returns camera_from_world on the circle, looking along it; `degrees` is the angle travelled.
Rigid3d PoseOnRing(double degrees, double radius_m = kRingRadius_m);
// Returns `count` poses from `begin_degrees` on.
std::vector<Rigid3d> PosesOnRing(double begin_degrees, double step_degrees, int count,
                                 double radius_m = kRingRadius_m);

struct SyntheticMapOptions {
  LocalMapId local_map = {0xa};
  uint64_t seed = 1;
  // Drift of each step between keyframes: a turn about the vertical, and a share of its length.
  double drift_yaw_rad = 0;
  double drift_scale = 0;
  double pixel_noise_px = 0.3;
  int flipped_bits = 8;  // Number of bits flipped in each observed descriptor.
  // Share of the world's points that look like another one to this map.
  double share_of_mistaken = 0;
  size_t min_observations = 2;
  // A point is followed through so many keyframes, then seen anew as another one; 0: for ever.
  size_t max_observations = 0;
  // 1 / the map's unit. The map is monocular, without a baseline, where it is not 1.
  double scale = 1;
};

struct SyntheticMap {
  Map map;  // Its frame is that of its first camera.
  std::map<KeyframeId, Rigid3d> true_camera_from_world;
  std::map<MapPointId, size_t> world_point;
};

SyntheticMap MakeSyntheticMap(const SyntheticWorld& world, const std::vector<Rigid3d>& poses,
                              const SyntheticMapOptions& options = {});

// Returns the root mean square of the camera centres' errors after one rigid alignment, over the
// keyframes that `truth` knows.
double AteRmse_m(const std::map<KeyframeId, Rigid3d>& estimate,
                 const std::map<KeyframeId, Rigid3d>& truth);
std::map<KeyframeId, Rigid3d> PosesOf(const Map& map);

// Returns the mean over all observations of the squared reprojection error, each at most 100 px^2.
double MeanReprojectionError_px2(const Map& map);

}  // namespace corbslam::testing

#endif  // CORBSLAM_SLAM_VERIFICATION_TESTING_SYNTHETIC_WORLD_H_
