// Finds from the pixels of two pictures alone how one camera moved between them, and where what
// they show is: how a map begins that has no depths.
#ifndef CORBSLAM_SLAM_MONOCULAR_TWO_VIEW_GEOMETRY_H_
#define CORBSLAM_SLAM_MONOCULAR_TWO_VIEW_GEOMETRY_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/types/span.h"
#include "slam/camera/camera.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// One thing in both pictures; undistorted pixels of the camera.
struct TwoViewMatch {
  Eigen::Vector2d pixel_1 = Eigen::Vector2d::Zero();
  Eigen::Vector2d pixel_2 = Eigen::Vector2d::Zero();
  double variance_px2 = 1;  // Of either pixel.
};

struct TwoViewOptions {
  // So many points at least must have depths that mean something.
  int min_points = 50;
  // They must see the two cameras under this angle at least. Less is what noise and a wrong
  // distortion make of a camera that turned.
  double min_parallax_rad = 0.01745;  // 1 degree.
  // It must be so many standard deviations of what noise makes of two rays, too: of large
  // keypoints, whose pixels are coarse, a degree is nothing.
  double min_parallax_sigmas = 4;
  // Of what agrees with the motion, so much must also lie before both cameras, ...
  double min_share_in_front = 0.9;
  // ... and of the other motions that explain as much of the pixels none may have this much of it.
  double max_second_share = 0.7;
  int iterations = 200;
  uint64_t seed = 0;
};

// Why there is no motion, or that there is one.
enum class TwoViewVerdict {
  kFound,
  kFewMatches,      // Too few matches, or too few of them agree with any motion.
  kLittleParallax,  // The camera stood still, turned on the spot, or moved too little.
  kAmbiguous,       // Several motions explain the pixels (a plane, seen from too near by).
};

struct TwoViewPoint {
  Eigen::Vector3d x_in_1 = Eigen::Vector3d::Zero();
  double parallax_rad = 0;
};

struct TwoViewGeometry {
  TwoViewVerdict verdict = TwoViewVerdict::kFewMatches;
  // True: a homography explains the matches better, so that the motion is from it.
  bool is_planar = false;
  // Share of the homography in the scores of both models: R_H of the paper.
  double homography_share = 0;
  // The angle that min_points points reach beyond their noise, also where that is too little.
  double parallax_rad = 0;
  // The rest is set if there is a motion. Its translation has length 1: nothing says more.
  Rigid3d two_from_one;
  // One entry a match; nullopt where the match disagrees, or its parallax says no depth.
  std::vector<std::optional<TwoViewPoint>> points;
};

// Fits a homography and an essential matrix side by side to samples of eight, takes the model that
// explains more, and of the motions that it may come from the one that lays what is seen before
// both cameras. It refuses what is not beyond doubt. The camera's pixels are undistorted, so that
// rays through any lens are what a pinhole sees. Source: Mur-Artal, Montiel and Tardos, "ORB-SLAM",
// T-RO 2015, section IV. The same input and seed give the same result. Pure; any thread.
TwoViewGeometry FindTwoViewGeometry(const Camera& camera, absl::Span<const TwoViewMatch> matches,
                                    const TwoViewOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MONOCULAR_TWO_VIEW_GEOMETRY_H_
