// Chooses corners that cover the image evenly.
#ifndef CORBSLAM_SLAM_FEATURES_CORNER_SPREAD_H_
#define CORBSLAM_SLAM_FEATURES_CORNER_SPREAD_H_

#include <vector>

#include "slam/features/fast_corners.h"

namespace corbslam {

// Keeps at most `wanted` of `corners`: the image is split into quarters again and again, the
// largest boxes first and among equal ones the fullest, until there are as many boxes that hold a
// corner as are wanted; each keeps its corner of the highest score. Ordered by row and column.
// All corners must lie inside width_px x height_px.
void SpreadCorners(int width_px, int height_px, int wanted, std::vector<Corner>& corners);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FEATURES_CORNER_SPREAD_H_
