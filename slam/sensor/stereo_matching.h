// Measures the disparities of the keypoints of a rectified pair.
#ifndef CORBSLAM_SLAM_SENSOR_STEREO_MATCHING_H_
#define CORBSLAM_SLAM_SENSOR_STEREO_MATCHING_H_

#include "slam/features/keypoint.h"
#include "slam/features/orb_extractor.h"
#include "slam/sensor/row_offset.h"
#include "slam/sensor/thread_pair.h"

namespace corbslam {

struct StereoMatchingOptions {
  // Largest disparity (left minus right column) in level-0 pixels. It belongs to the nearest point,
  // which is one baseline away when it is fx.
  double max_disparity_px = 0;
  // This is added to each disparity that is measured: what the pictures' principal points differ by
  // beyond whole columns.
  double disparity_offset_px = 0;
  // Largest distance of descriptors that may match, in bits.
  int max_hamming = 75;
  // Matches whose grey values differ by more than this many times the median's are dropped.
  double max_median_ratio = 2.1;
};

// Sets disparity_px of `left` where a counterpart is found, and 0 elsewhere. The counterpart has
// the most similar descriptor in the band of rows that the octave allows; then comes the shift of
// least absolute differences of 11 x 11 pixels, refined below a pixel by least squares. The
// pyramids are those the features were extracted from; `threads` share the work, with the same
// result. The method follows ORB-SLAM2 (Mur-Artal and Tardos, T-RO 2017, III.A). Returns what the
// counterparts show of the pair's rows.
RowEvidence MatchStereo(const Features& right, const ImagePyramid& left_pyramid,
                        const ImagePyramid& right_pyramid, const StereoMatchingOptions& options,
                        ThreadPair& threads, Features& left);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_STEREO_MATCHING_H_
