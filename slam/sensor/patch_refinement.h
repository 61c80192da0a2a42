// Finds where a patch of one picture lies in another, to a part of a pixel.
#ifndef CORBSLAM_SLAM_SENSOR_PATCH_REFINEMENT_H_
#define CORBSLAM_SLAM_SENSOR_PATCH_REFINEMENT_H_

#include <opencv2/core/mat.hpp>
#include <optional>

namespace corbslam {

inline constexpr int kPatchRadius_px = 5;
inline constexpr int kPatchSide_px = 2 * kPatchRadius_px + 1;

// How much further right and lower the second view of a patch lies than was thought.
struct PatchShift {
  float x_px = 0;
  float y_px = 0;
};

// Returns how far the patch around (left_x, y) of `left` lies from (right_x, y) in `right`; both
// are CV_8UC1, the patch is inside `left`. The method is least squares of grey values (Lucas and
// Kanade, IJCAI 1981), up to an offset of them: the pictures of a pair differ in exposure. The
// middle counts most, and pixels that the shift does not explain, those of what lies behind the
// edge that the corner is on, hardly count. Rows that are off by a part of a pixel are estimated,
// too. Returns nothing where the shift strays by more than a pixel, or the patch has no vertical
// structure.
std::optional<PatchShift> RefineAlignment(const cv::Mat& left, const cv::Mat& right, int left_x,
                                          int y, int right_x);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_PATCH_REFINEMENT_H_
