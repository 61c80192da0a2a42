#include "slam/matching/match_point.h"

namespace corbslam {
namespace {

constexpr double kMinViewCosine = 0.5;
constexpr double kNearTolerance = 0.8;
constexpr double kFarTolerance = 1.2;

// Predicts the view of a MatchPoint or of a MapPoint.
template <typename Point>
std::optional<PredictedView> Predict(const Point& point, const Camera& camera,
                                     const Rigid3d& camera_from_map) {
  const Eigen::Vector3d x_in_camera = camera_from_map * point.position_in_map;
  if (x_in_camera.z() <= 0) return std::nullopt;
  PredictedView view;
  view.pixel = Project(camera, x_in_camera);
  if (!IsInImage(camera, view.pixel)) return std::nullopt;
  const double distance = x_in_camera.norm();
  if (distance < kNearTolerance * point.min_distance) return std::nullopt;
  if (distance > kFarTolerance * point.max_distance) return std::nullopt;
  const Eigen::Vector3d normal_in_camera = camera_from_map.rotation * point.normal_in_map;
  view.view_cosine = x_in_camera.dot(normal_in_camera) / distance;
  if (view.view_cosine < kMinViewCosine) return std::nullopt;
  view.octave = ScalePyramid::PredictOctave(point.max_distance, distance);
  if (camera.IsMetric()) view.disparity_px = DisparityFromDepth(camera, x_in_camera.z());
  return view;
}

}  // namespace

MatchPoint MakeMatchPoint(const MapPoint& point) {
  return {point.id,           point.position_in_map, point.normal_in_map,
          point.min_distance, point.max_distance,    point.descriptor};
}

std::optional<PredictedView> PredictView(const MatchPoint& point, const Camera& camera,
                                         const Rigid3d& camera_from_map) {
  return Predict(point, camera, camera_from_map);
}

std::optional<PredictedView> PredictView(const MapPoint& point, const Camera& camera,
                                         const Rigid3d& camera_from_map) {
  return Predict(point, camera, camera_from_map);
}

}  // namespace corbslam
