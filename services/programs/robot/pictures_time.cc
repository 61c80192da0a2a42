#include "services/programs/robot/pictures_time.h"

#include <cmath>
#include <utility>
#include <vector>

#include "slam/util/median.h"

namespace corbslam {

double PicturesTime_s(const ImageSource& source, size_t frames) {
  std::vector<double> intervals_s;
  for (size_t i = 1; i < source.size(); ++i) {
    const SourceFrame before = source.frame(i - 1);
    const SourceFrame after = source.frame(i);
    if (before.drive != after.drive) continue;
    // A sequence that is played backwards has falling times.
    const auto interval_ns = static_cast<double>(after.timestamp_ns - before.timestamp_ns);
    intervals_s.push_back(std::abs(interval_ns) * 1e-9);
  }
  if (intervals_s.empty()) return 0;
  return static_cast<double>(frames) * MeanMedian(std::move(intervals_s));
}

}  // namespace corbslam
