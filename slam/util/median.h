#ifndef CORBSLAM_SLAM_UTIL_MEDIAN_H_
#define CORBSLAM_SLAM_UTIL_MEDIAN_H_

#include <algorithm>
#include <cstddef>
#include <vector>

namespace corbslam {

// Returns the middle one of the values, the upper of the two middle ones of an even number. There
// must be at least one.
template <typename T>
T Median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Returns the median that statistics report: for an even number of values the mean of the middle
// two. There must be at least one.
inline double MeanMedian(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*std::max_element(values.begin(), middle) + *middle) / 2;
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_MEDIAN_H_
