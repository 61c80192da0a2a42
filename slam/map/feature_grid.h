// Sorts keypoints into square cells of the image, to find those near a pixel.
#ifndef CORBSLAM_SLAM_MAP_FEATURE_GRID_H_
#define CORBSLAM_SLAM_MAP_FEATURE_GRID_H_

#include <cstdint>
#include <vector>

#include "slam/camera/camera.h"
#include "slam/features/keypoint.h"

namespace corbslam {

// Immutable after construction; safe to read from any thread.
class FeatureGrid {
 public:
  FeatureGrid() = default;
  FeatureGrid(const Camera& camera, const std::vector<Keypoint>& keypoints);

  // Appends to `found` the indices of the keypoints within a square of half side `radius_px`
  // around (x, y) whose octave is in [min_octave, max_octave]; in a fixed order. `keypoints` are
  // those of the constructor.
  void FindNear(const std::vector<Keypoint>& keypoints, double x_px, double y_px, double radius_px,
                int min_octave, int max_octave, std::vector<uint32_t>& found) const;

 private:
  int Column(double x_px) const;
  int Row(double y_px) const;

  int columns_ = 0;
  int rows_ = 0;
  // Cell c holds indices_[begin_[c]] to indices_[begin_[c + 1]].
  std::vector<uint32_t> begin_;
  std::vector<uint32_t> indices_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MAP_FEATURE_GRID_H_
