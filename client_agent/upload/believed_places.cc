#include "client_agent/upload/believed_places.h"

#include <algorithm>
#include <cmath>

#include "slam/camera/camera.h"

namespace corbslam::client_agent {
namespace {

constexpr double kMinDepth_m = 1e-6;

bool LooksTheSameFrom(const Keyframe& keyframe, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                      double bound_px) {
  const Camera& camera = keyframe.camera();
  const Eigen::Vector3d a_in_camera = keyframe.camera_from_map * a;
  const Eigen::Vector3d b_in_camera = keyframe.camera_from_map * b;
  if (a_in_camera.z() < kMinDepth_m || b_in_camera.z() < kMinDepth_m) return false;
  const Eigen::Vector2d moved = Project(camera, a_in_camera) - Project(camera, b_in_camera);
  if (moved.norm() > bound_px) return false;
  if (!camera.IsMetric()) return true;
  const double disparity_px =
      DisparityFromDepth(camera, a_in_camera.z()) - DisparityFromDepth(camera, b_in_camera.z());
  return std::abs(disparity_px) <= bound_px;
}

}  // namespace

void BelievedPlaces::PlaceKeyframe(KeyframeId id, const Rigid3d& camera_from_local,
                                   bool points_follow) {
  const auto [it, added] = camera_from_local_.try_emplace(id, camera_from_local);
  if (added) return;
  const Rigid3d now_from_before = camera_from_local * it->second.Inverse();
  it->second = camera_from_local;
  if (points_follow) return;
  for (const MapPointId point : Followers(id)) {
    std::optional<Eigen::Vector3d>& position = points_.at(point).position_in_reference;
    if (position.has_value()) position = now_from_before * *position;
  }
}

void BelievedPlaces::AddPoint(MapPointId id, const Eigen::Vector3d& position_in_local,
                              KeyframeId reference) {
  points_[id] = {reference, camera_from_local_.at(reference) * position_in_local};
  followers_.Add(reference, id);
}

void BelievedPlaces::MovePoint(MapPointId id, const Eigen::Vector3d& position_in_local) {
  const auto it = points_.find(id);
  if (it == points_.end()) return;
  it->second.position_in_reference =
      camera_from_local_.at(it->second.reference) * position_in_local;
}

void BelievedPlaces::ForgetPlaces() {
  for (auto& [id, point] : points_) point.position_in_reference.reset();
}

std::optional<Eigen::Vector3d> BelievedPlaces::Position(MapPointId id) const {
  const auto it = points_.find(id);
  if (it == points_.end() || !it->second.position_in_reference.has_value()) return std::nullopt;
  const Rigid3d& camera_from_local = camera_from_local_.at(it->second.reference);
  return camera_from_local.Inverse() * *it->second.position_in_reference;
}

const std::vector<MapPointId>& BelievedPlaces::Followers(KeyframeId reference) {
  return followers_.Of(reference, [this](MapPointId point) { return points_.contains(point); });
}

bool LooksTheSame(const Map& map, const MapPoint& point, const Eigen::Vector3d& told,
                  double bound_px) {
  return std::ranges::all_of(point.observations, [&](const auto& observation) {
    return LooksTheSameFrom(*map.FindKeyframe(observation.first), point.position_in_map, told,
                            bound_px);
  });
}

}  // namespace corbslam::client_agent
