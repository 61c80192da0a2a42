// ORB features (Rublee et al., ICCV 2011): FAST corners on a scale pyramid, spread evenly over the
// image, oriented by the intensity centroid, described by 256 steered binary tests.
#ifndef CORBSLAM_SLAM_FEATURES_ORB_EXTRACTOR_H_
#define CORBSLAM_SLAM_FEATURES_ORB_EXTRACTOR_H_

#include <array>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "absl/status/status.h"
#include "slam/features/fast_corners.h"
#include "slam/features/keypoint.h"

namespace corbslam {

struct OrbOptions {
  // Number of features over all levels; fewer are returned where the image has no more corners.
  int features = 2000;
  // Least contrast of a corner, grey values. Cells of the image that have no corner at the first
  // threshold take those of the second.
  int fast_threshold = 20;
  int min_fast_threshold = 7;
  // Side of the cells, in pixels of each level.
  int cell_px = 32;

  // INVALID_ARGUMENT names the field, its value and its limits.
  absl::Status Validate() const;
  friend bool operator==(const OrbOptions&, const OrbOptions&) = default;
};

// The grey image at every octave (CV_8UC1, not blurred); levels[0] has the image's own size. Level
// i + 1 is level i resampled by 1 / ScalePyramid::kFactor, sizes rounded, until a level would be
// smaller than a keypoint's surroundings: the remaining ones are empty.
struct ImagePyramid {
  std::array<cv::Mat, ScalePyramid::kLevels> levels;

  // Returns level-0 pixels per pixel of that level; the two axes differ by rounding of the level's
  // size.
  double ScaleX(int octave) const;
  double ScaleY(int octave) const;
  // Converts a position in a level to one in level 0 and back: pixel centres are at integers, so
  // x_0 = (x + 0.5) * scale - 0.5.
  float ToLevel0X(float x_px, int octave) const;
  float ToLevel0Y(float y_px, int octave) const;
  float FromLevel0X(float x_px, int octave) const;
  float FromLevel0Y(float y_px, int octave) const;
};

// Resamples `grey` (CV_8UC1, level 0, shared not copied) into `pyramid`, reusing its buffers.
void BuildImagePyramid(const cv::Mat& grey, ImagePyramid& pyramid);

// One camera's extractor, which keeps buffers from image to image. Thread-compatible: one thread at
// a time uses it, but for ExtractLevel.
class OrbExtractor {
 public:
  // `options` must be valid.
  explicit OrbExtractor(const OrbOptions& options);

  // Replaces `features` and `pyramid` by those of a CV_8UC1 image of at least 64 x 64 pixels
  // (INVALID_ARGUMENT otherwise). Keypoints are in pixels of `grey`, ordered by octave and, within
  // one, by row and column. pyramid.levels[0] shares grey's pixels. The result depends on the
  // pixels and options alone.
  absl::Status Extract(const cv::Mat& grey, Features& features, ImagePyramid& pyramid);

  // Keeps features from where `mask` (CV_8UC1, of the images' size) is 0, before the others are
  // spread over the image; an empty one masks nothing.
  void SetMask(const cv::Mat& mask) { mask_ = mask; }

  // They do the same in parts, for threads that share the work: first Begin; then ExtractLevel of
  // each octave, of different ones at the same time if wanted; then Gather, which does not change
  // the pyramid.
  absl::Status Begin(const cv::Mat& grey, ImagePyramid& pyramid);
  void ExtractLevel(const ImagePyramid& pyramid, int octave);
  absl::Status Gather(Features& features) const;

  const OrbOptions& options() const { return options_; }

 private:
  // What a level yields, and its buffers.
  struct Level {
    int wanted = 0;  // Number of features that it should give.
    FastDetector detector;
    std::vector<Corner> corners;
    cv::Mat blurred;
    Features features;
    absl::Status status;
  };

  void Detect(const ImagePyramid& pyramid, int octave, Level& level) const;
  void DropMasked(const ImagePyramid& pyramid, int octave, std::vector<Corner>& corners) const;
  static void Describe(const ImagePyramid& pyramid, int octave, Level& level);

  OrbOptions options_;
  cv::Mat mask_;
  std::array<Level, ScalePyramid::kLevels> levels_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FEATURES_ORB_EXTRACTOR_H_
