// Finds by how many rows the pictures of a rectified pair are apart, and moves them together.
#ifndef CORBSLAM_SLAM_SENSOR_ROW_OFFSET_H_
#define CORBSLAM_SLAM_SENSOR_ROW_OFFSET_H_

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace corbslam {

// What the counterparts of one pair's keypoints show: how much lower the right ones lie, in rows of
// the full picture.
struct RowEvidence {
  double median_px = 0;
  size_t counterparts = 0;
};

// Learns from one pair after the other what a rig's calibration does not say: that the right
// picture lies lower than it should. It acts on what is beyond doubt and worth it alone, so that a
// rig that is right stays as it is (docs/adr/0047-rows-put-right.md). Thread-compatible.
class RowOffset {
 public:
  // Takes the next pair's evidence, of pictures that correction_px() had been applied to.
  void Add(const RowEvidence& evidence);

  // Rows by which the right picture is to be moved up; 0 until ten pairs say that it is to be
  // moved.
  double correction_px() const { return correction_px_; }

 private:
  std::vector<double> medians_px_;
  double correction_px_ = 0;
};

// Returns the picture (CV_8UC1) moved up by so many rows, between rows by Catmull and Rom's cubic.
// What comes in from beyond it repeats its edge.
cv::Mat MoveUp(const cv::Mat& picture, double rows_px);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_ROW_OFFSET_H_
