#include "slam/evaluation/true_travel.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>

namespace corbslam {
namespace {

constexpr int64_t kMaxInterval_ns = 100'000'000;
// A true pose may stand for a frame that comes up to this share of an interval later.
constexpr double kTolerance = 0.25;

bool IsEarlier(const StampedPose& pose, int64_t time_ns) { return pose.timestamp_ns < time_ns; }
bool IsLater(int64_t time_ns, const StampedPose& pose) { return time_ns < pose.timestamp_ns; }

// Returns the median interval between frames, at most kMaxInterval_ns; 0 where all times are equal.
int64_t FrameInterval_ns(const std::vector<PosePair>& pairs) {
  std::vector<int64_t> intervals_ns;
  for (size_t i = 1; i < pairs.size(); ++i) {
    const int64_t interval_ns = pairs[i].truth.timestamp_ns - pairs[i - 1].truth.timestamp_ns;
    if (interval_ns > 0) intervals_ns.push_back(interval_ns);
  }
  if (intervals_ns.empty()) return 0;
  const auto middle = intervals_ns.begin() + static_cast<ptrdiff_t>(intervals_ns.size() / 2);
  std::nth_element(intervals_ns.begin(), middle, intervals_ns.end());
  return std::min(*middle, kMaxInterval_ns);
}

// Returns the true poses between two times: all of them, or thinned to the frames' rate.
class PosesBetween {
 public:
  PosesBetween(const Trajectory& truth, int64_t interval_ns)
      : truth_(truth), interval_ns_(interval_ns) {}

  std::vector<Eigen::Vector3d> operator()(int64_t begin_ns, int64_t end_ns) const {
    if (interval_ns_ <= 0 || end_ns <= begin_ns) return {};
    const auto first = std::upper_bound(truth_.begin(), truth_.end(), begin_ns, IsLater);
    const auto last = std::lower_bound(first, truth_.end(), end_ns, IsEarlier);
    const double steps =
        std::round(static_cast<double>(end_ns - begin_ns) / static_cast<double>(interval_ns_));
    if (first == last || steps < 2) return {};
    const bool all = steps > static_cast<double>(last - first);
    std::vector<Eigen::Vector3d> positions;
    const double step_ns = static_cast<double>(end_ns - begin_ns) / steps;
    double next_ns = step_ns;
    for (auto it = first; it != last; ++it) {
      const auto after_ns = static_cast<double>(it->timestamp_ns - begin_ns);
      if (!all && after_ns < next_ns - kTolerance * step_ns) continue;
      positions.push_back(it->world_from_camera.translation);
      next_ns = step_ns * (std::floor(after_ns / step_ns + kTolerance) + 1);
    }
    return positions;
  }

 private:
  const Trajectory& truth_;
  const int64_t interval_ns_;
};

}  // namespace

TrueTravel MeasureTravel(const std::vector<PosePair>& pairs, const Trajectory& truth) {
  const PosesBetween poses_between(truth, FrameInterval_ns(pairs));
  TrueTravel travel;
  double travelled_m = 0;
  for (size_t i = 0; i < pairs.size(); ++i) {
    double before_m = travelled_m;
    if (i > 0) {
      const StampedPose& begin = pairs[i - 1].truth;
      const StampedPose& end = pairs[i].truth;
      Eigen::Vector3d at = begin.world_from_camera.translation;
      for (const Eigen::Vector3d& next : poses_between(begin.timestamp_ns, end.timestamp_ns)) {
        before_m += (next - at).norm();
        at = next;
      }
      travelled_m = before_m + (end.world_from_camera.translation - at).norm();
    }
    travel.at_m.push_back(travelled_m);
    travel.before_m.push_back(before_m);
  }
  return travel;
}

}  // namespace corbslam
