// FAST-9 corners (Rosten and Drummond, ECCV 2006) of one image: score, non-maximum suppression and
// a threshold that adapts to each cell of the image.
#ifndef CORBSLAM_SLAM_FEATURES_FAST_CORNERS_H_
#define CORBSLAM_SLAM_FEATURES_FAST_CORNERS_H_

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace corbslam {

// A corner in pixels of its image. The score is the smallest threshold at which the pixel no longer
// is a corner: at lower ones, 9 neighbours in a row on the circle of 16 are all brighter, or all
// darker, than the centre by more than the threshold.
struct Corner {
  int16_t x_px = 0;
  int16_t y_px = 0;
  uint8_t score = 0;
  friend bool operator==(const Corner&, const Corner&) = default;
};

struct FastOptions {
  int threshold = 20;
  // Threshold in cells without a corner at `threshold`.
  int min_threshold = 7;
  int cell_px = 32;
  // No corner lies nearer to the image's border; at least 4.
  int margin_px = 16;
};

// Keeps buffers from image to image. Thread-compatible.
class FastDetector {
 public:
  // Replaces `corners` by those of a CV_8UC1 image, by row and column.
  void Detect(const cv::Mat& image, const FastOptions& options, std::vector<Corner>& corners);

 private:
  // Works on three rows of scores at a time, because a row's maxima need those beside it.
  void CollectMaxima(const cv::Mat& image, const FastOptions& options,
                     std::vector<Corner>& corners);
  void DropWeakCorners(const cv::Mat& image, const FastOptions& options,
                       std::vector<Corner>& corners);

  std::array<std::vector<uint8_t>, 3> scores_;
  std::vector<uint8_t> maxima_;  // Maxima of one row.
  // Column and row of cells that a pixel's column and row belong to.
  std::vector<int> cell_of_column_;
  std::vector<int> cell_of_row_;
  std::vector<uint8_t> cell_has_strong_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FEATURES_FAST_CORNERS_H_
