// Keeps the matches whose keypoints are turned by about the same angle.
#ifndef CORBSLAM_SLAM_MATCHING_ORIENTATION_HISTOGRAM_H_
#define CORBSLAM_SLAM_MATCHING_ORIENTATION_HISTOGRAM_H_

#include <array>
#include <cstddef>

namespace corbslam {

// Counts differences of orientation in 30 equal bins; the three fullest are kept, if they hold at
// least a tenth of the fullest (Mur-Artal and Tardos, ICRA 2014). Add all, then Select, then ask.
class OrientationHistogram {
 public:
  void Add(float angle_a_rad, float angle_b_rad) { ++counts_[Bin(angle_a_rad, angle_b_rad)]; }
  void Select();
  bool IsKept(float angle_a_rad, float angle_b_rad) const {
    return kept_[Bin(angle_a_rad, angle_b_rad)];
  }

 private:
  static constexpr int kBins = 30;
  static size_t Bin(float angle_a_rad, float angle_b_rad);

  std::array<int, kBins> counts_ = {};
  std::array<bool, kBins> kept_ = {};
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MATCHING_ORIENTATION_HISTOGRAM_H_
