// 256 binary tests on a smoothed patch, turned with the patch (steered BRIEF; Calonder et al., ECCV
// 2010; Rublee et al., ICCV 2011).
#ifndef CORBSLAM_SLAM_FEATURES_STEERED_BRIEF_H_
#define CORBSLAM_SLAM_FEATURES_STEERED_BRIEF_H_

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "slam/features/keypoint.h"

namespace corbslam {

// The bit is set where the first pixel is darker than the second; offsets from the patch's centre,
// within a disc of radius kBriefRadius_px.
struct BriefTest {
  int8_t x1 = 0;
  int8_t y1 = 0;
  int8_t x2 = 0;
  int8_t y2 = 0;
};
inline constexpr int kBriefRadius_px = 15;
inline constexpr int kBriefTests = 256;
using BriefPattern = std::array<BriefTest, kBriefTests>;

// Returns the pattern of the whole system: descriptors of two robots match only when they share it.
const BriefPattern& LearnedBriefPattern();

// A pattern turned in advance to each of kAngles directions. It is immutable: any number of threads
// may use it.
class SteeredBrief {
 public:
  static constexpr int kAngles = 256;

  explicit SteeredBrief(const BriefPattern& pattern);

  // The patch's centre must be kBriefRadius_px + 1 or more from the border of `smoothed`, CV_8UC1.
  Descriptor Describe(const cv::Mat& smoothed, int x_px, int y_px, float angle_rad) const;

 private:
  // Positions are in a patch of kPatchStride pixels a row.
  struct Pair {
    uint16_t first;
    uint16_t second;
  };
  static constexpr int kPatchStride = 32;

  std::vector<std::array<Pair, kBriefTests>> pairs_of_angle_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_FEATURES_STEERED_BRIEF_H_
