#include "client_agent/tracking/camera_motion.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "slam/geometry/lie.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kMostIntervals = 15;
constexpr double kMostFrames = 1e6;

}  // namespace

void FrameRhythm::Add(int64_t since_ns) {
  if (since_ns == 0) return;
  newest_ns_.push_back(std::abs(since_ns));
  if (newest_ns_.size() > kMostIntervals) newest_ns_.pop_front();
}

int FrameRhythm::FramesIn(int64_t since_ns) const {
  if (newest_ns_.empty()) return 1;
  std::vector<int64_t> intervals(newest_ns_.begin(), newest_ns_.end());
  const auto lower = intervals.begin() + static_cast<ptrdiff_t>((intervals.size() - 1) / 4);
  std::ranges::nth_element(intervals, lower);
  const double frames =
      std::round(static_cast<double>(std::abs(since_ns)) / static_cast<double>(*lower));
  return static_cast<int>(std::clamp(frames, 1.0, kMostFrames));
}

Rigid3d GoOnFor(double times, const Rigid3d& camera_from_previous) {
  return ExpSE3(times * LogSE3(camera_from_previous));
}

}  // namespace corbslam::client_agent
