// Finds the horizontal shift between two views of a patch of a rectified pair.
#ifndef CORBSLAM_SLAM_SENSOR_PATCH_ALIGNMENT_H_
#define CORBSLAM_SLAM_SENSOR_PATCH_ALIGNMENT_H_

#include <opencv2/core/mat.hpp>
#include <optional>

namespace corbslam {

struct PatchAlignment {
  // Column in the right image, to a part of a pixel.
  float right_x_px = 0;
  // How much lower the patch lies in the right image.
  float lower_px = 0;
  // Sum of absolute differences of the patches at the best whole column, their means made equal.
  int difference = 0;
};

// Finds the patch of 11 x 11 pixels around (left_x, y) of `left` within 5 columns of (right_x, y)
// of `right`, to a part of a pixel as patch_refinement.h says; both are CV_8UC1. Returns nothing
// where the images end, or where the best column is the range's first or last, or the refinement
// leaves the neighbourhood of that column.
std::optional<PatchAlignment> AlignPatch(const cv::Mat& left, const cv::Mat& right, int left_x,
                                         int y, int right_x);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_PATCH_ALIGNMENT_H_
