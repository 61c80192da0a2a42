// Computes quantiles of what was measured.
#ifndef CORBSLAM_TESTS_REPLAY_QUANTILE_H_
#define CORBSLAM_TESTS_REPLAY_QUANTILE_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace corbslam::tests {

// Returns the smallest value that at least this share (0 to 1) of the values do not exceed; 0 for
// none.
inline double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<size_t>(std::ceil(share * static_cast<double>(values.size())));
  return values[std::max<size_t>(rank, 1) - 1];
}

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_REPLAY_QUANTILE_H_
