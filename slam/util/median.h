#ifndef CORBSLAM_SLAM_UTIL_MEDIAN_H_
#define CORBSLAM_SLAM_UTIL_MEDIAN_H_

#include <algorithm>
#include <cstddef>
#include <vector>

namespace corbslam {

// The middle one of the values, the upper of the two middle ones of an even number. There must be
// at least one.
template <typename T>
T Median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_MEDIAN_H_
