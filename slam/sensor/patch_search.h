// Finds where a patch of one picture is in another one that was taken from elsewhere.
#ifndef CORBSLAM_SLAM_SENSOR_PATCH_SEARCH_H_
#define CORBSLAM_SLAM_SENSOR_PATCH_SEARCH_H_

#include <Eigen/Core>
#include <optional>

#include "slam/sensor/halved_picture.h"

namespace corbslam {

struct PatchSearch {
  // Patches are sought on so many levels, the largest.
  static constexpr int kLevels = 3;

  // The patch's middle, pixels of the source's first level.
  Eigen::Vector2d source_px;
  // What a step in the searched picture is in the source: nearer surfaces are larger, and turned.
  Eigen::Matrix2d source_from_now;
  // Where it is expected, pixels of the searched picture's first level.
  Eigen::Vector2d predicted_px;
  // The level to begin with. A patch is found from some 3 pixels away of that level.
  int first_level = kLevels - 1;
};

// Returns where the patch of 8 x 8 pixels is in `now`, pixels of its first level, to a part of one;
// nullopt where it strays, leaves a picture, has too little structure or does not look the same up
// to brightness and contrast. From level to level the source's patch, warped as the search says, is
// moved over the picture (inverse compositional least squares: Baker and Matthews, IJCV 2004).
std::optional<Eigen::Vector2d> FindPatch(const HalvedPicture& source, const HalvedPicture& now,
                                         const PatchSearch& search);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_PATCH_SEARCH_H_
