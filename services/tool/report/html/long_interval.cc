#include "services/tool/report/html/long_interval.h"

#include <algorithm>
#include <cstddef>

namespace corbslam::services {

double LongInterval_s(std::vector<double> intervals_s) {
  constexpr double kLongIntervals = 3;
  if (intervals_s.empty()) return 0;
  const auto middle = intervals_s.begin() + static_cast<ptrdiff_t>(intervals_s.size() / 2);
  std::nth_element(intervals_s.begin(), middle, intervals_s.end());
  return kLongIntervals * *middle;
}

}  // namespace corbslam::services
