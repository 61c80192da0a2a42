#include "map_store/fusion/overlap_vagueness.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "slam/geometry/lie.h"

namespace corbslam::map_store {
namespace {

// Overlaps of recorded and simulated drives leave 0.1 to 0.3 hundredths. One that knew the other
// robot's ground from 30 m away left 2, and was off by four times that.
constexpr double kMostShare = 0.01;

// Returns the median distance of what the keyframe sees, which may be nearer than what both see.
std::optional<double> MedianDistance(const Map& map, KeyframeId id) {
  const Keyframe* keyframe = map.FindKeyframe(id);
  if (keyframe == nullptr) return std::nullopt;
  std::vector<double> distances;
  for (const MapPointId seen : keyframe->points) {
    const MapPoint* point = seen.IsValid() ? map.FindPoint(seen) : nullptr;
    if (point == nullptr) continue;
    distances.push_back((keyframe->camera_from_map * point->position_in_map).norm());
  }
  if (distances.empty()) return std::nullopt;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

// Returns the standard deviation, along an axis, of where a point of the candidate's camera is to
// that camera.
double SigmaAt(const Eigen::Vector3d& point, const Overlap& overlap) {
  Eigen::Matrix<double, 3, 6> moved_by;
  moved_by << Eigen::Matrix3d::Identity(), -Skew(point);
  const Matrix6d covariance = overlap.covariance.topLeftCorner<6, 6>();
  return std::sqrt((moved_by * covariance * moved_by.transpose()).trace() / 3);
}

}  // namespace

bool IsVague(const Overlap& overlap, const Map& map) {
  const std::optional<double> distance = MedianDistance(map, overlap.candidate);
  if (!distance.has_value()) return false;
  const double sigma = std::max(SigmaAt(Eigen::Vector3d::Zero(), overlap),
                                SigmaAt(overlap.candidate_from_query.translation, overlap));
  return sigma > kMostShare * *distance;
}

}  // namespace corbslam::map_store
