#include "client_agent/mapping/point_creation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "slam/map/scene_depth.h"
#include "slam/matching/triangulation_matching.h"
#include "slam/solvers/triangulation.h"

namespace corbslam::client_agent {
namespace {

constexpr int kNeighbours = 10;
// Without depths points come from pairs of views alone, of which more are looked at.
constexpr int kNeighboursWithoutDepth = 20;
// Keyframes that are nearer to each other than this share of the scene's depth say no depths
// (ORB-SLAM, T-RO 2015, VI.C).
constexpr double kLeastOfDepth = 0.01;
constexpr double kMaxParallaxCosine = 0.9998;
constexpr double kMaxChi2Monocular = 5.991;
constexpr double kMaxChi2Stereo = 7.815;
// Largest mismatch between the ratio of distances and the ratio of octave scales.
constexpr double kMaxScaleMismatch = 1.5 * ScalePyramid::kFactor;

struct NewPoint {
  Eigen::Vector3d position_in_map;
  uint32_t keypoint_a = 0;
  uint32_t keypoint_b = 0;
};

Eigen::Vector3d Ray(const Keyframe& keyframe, const Keypoint& keypoint) {
  return (keyframe.camera_from_map.rotation.conjugate() *
          Unproject(keyframe.camera(), keypoint.x_px, keypoint.y_px, 1))
      .normalized();
}

// Cosine of the angle under which the point sees the baseline of its own keyframe's stereo pair.
double StereoCosine(const Camera& camera, const Keypoint& keypoint) {
  const double depth_m = DepthFromDisparity(camera, keypoint.disparity_px);
  return std::cos(2 * std::atan2(camera.baseline_m / 2, depth_m));
}

Eigen::Vector3d PointFromDepth(const Keyframe& keyframe, const Keypoint& keypoint) {
  const double depth_m = DepthFromDisparity(keyframe.camera(), keypoint.disparity_px);
  return keyframe.camera_from_map.Inverse() *
         Unproject(keyframe.camera(), keypoint.x_px, keypoint.y_px, depth_m);
}

bool FitsView(const Keyframe& keyframe, const Keypoint& keypoint, const Eigen::Vector3d& x_in_map) {
  const Eigen::Vector3d x_in_camera = keyframe.camera_from_map * x_in_map;
  if (x_in_camera.z() <= 0) return false;
  double error2 = (Project(keyframe.camera(), x_in_camera) - keypoint.Pixel()).squaredNorm();
  double limit = kMaxChi2Monocular;
  if (keypoint.HasDepth()) {
    const double right = Project(keyframe.camera(), x_in_camera).x() -
                         DisparityFromDepth(keyframe.camera(), x_in_camera.z()) -
                         (keypoint.x_px - keypoint.disparity_px);
    error2 += right * right;
    limit = kMaxChi2Stereo;
  }
  return error2 <= limit * ScalePyramid::Variance_px2(keypoint.octave);
}

bool FitsScales(const Keyframe& a, const Keypoint& keypoint_a, const Keyframe& b,
                const Keypoint& keypoint_b, const Eigen::Vector3d& x_in_map) {
  const double distance_a = (a.camera_from_map * x_in_map).norm();
  const double distance_b = (b.camera_from_map * x_in_map).norm();
  if (distance_a <= 0 || distance_b <= 0) return false;
  const double distances = distance_b / distance_a;
  const double scales =
      ScalePyramid::Scale(keypoint_a.octave) / ScalePyramid::Scale(keypoint_b.octave);
  return distances * kMaxScaleMismatch >= scales && distances <= scales * kMaxScaleMismatch;
}

bool IsFarEnough(const Map& map, const Keyframe& a, const Keyframe& b) {
  const double distance =
      (CameraCentre(a.camera_from_map) - CameraCentre(b.camera_from_map)).norm();
  if (b.camera().IsMetric()) return distance > b.camera().baseline_m;
  const std::optional<double> depth = MedianDepth(map, b);
  return depth.has_value() && distance > kLeastOfDepth * *depth;
}

std::vector<NewPoint> FindNewPoints(const Map& map, KeyframeId id_a, KeyframeId id_b) {
  std::vector<NewPoint> found;
  const Keyframe* a = map.FindKeyframe(id_a);
  const Keyframe* b = map.FindKeyframe(id_b);
  if (a == nullptr || b == nullptr || !IsFarEnough(map, *a, *b)) return found;
  for (const auto& [i, j] : MatchForTriangulation(*a, *b)) {
    if (const auto position = LocatePoint(*a, i, *b, j)) found.push_back({*position, i, j});
  }
  return found;
}

}  // namespace

std::optional<Eigen::Vector3d> LocatePoint(const Keyframe& a, uint32_t index_a, const Keyframe& b,
                                           uint32_t index_b) {
  const Keypoint& keypoint_a = a.keypoints()[index_a];
  const Keypoint& keypoint_b = b.keypoints()[index_b];
  const double rays = Ray(a, keypoint_a).dot(Ray(b, keypoint_b));
  constexpr double kNoStereo = 2;
  const double stereo_a = keypoint_a.HasDepth() ? StereoCosine(a.camera(), keypoint_a) : kNoStereo;
  const double stereo_b = keypoint_b.HasDepth() ? StereoCosine(b.camera(), keypoint_b) : kNoStereo;
  const double stereo = std::min(stereo_a, stereo_b);
  std::optional<Eigen::Vector3d> position;
  if (rays > 0 && rays < stereo && (stereo < kNoStereo || rays < kMaxParallaxCosine)) {
    const auto triangulated = TriangulatePoint(a.camera(), a.camera_from_map, keypoint_a.Pixel(),
                                               b.camera(), b.camera_from_map, keypoint_b.Pixel());
    if (triangulated.has_value()) position = triangulated->x_in_map;
  } else if (stereo < kNoStereo) {
    position = stereo_a < stereo_b ? PointFromDepth(a, keypoint_a) : PointFromDepth(b, keypoint_b);
  }
  if (!position.has_value()) return std::nullopt;
  if (!FitsView(a, keypoint_a, *position) || !FitsView(b, keypoint_b, *position) ||
      !FitsScales(a, keypoint_a, b, keypoint_b, *position)) {
    return std::nullopt;
  }
  return position;
}

std::vector<MapPointId> CreatePoints(KeyframeId keyframe, GuardedMap& guarded) {
  std::vector<MapPointId> made;
  const std::vector<CovisibleKeyframe> neighbours = guarded.Read([&](const Map& map) {
    const Keyframe* const centre = map.FindKeyframe(keyframe);
    const bool has_depths = centre == nullptr || centre->camera().IsMetric();
    return map.BestCovisible(keyframe, has_depths ? kNeighbours : kNeighboursWithoutDepth);
  });
  for (const CovisibleKeyframe& neighbour : neighbours) {
    // Another robot extends what it made itself.
    if (!guarded.IsOwn(neighbour.id)) continue;
    const std::vector<NewPoint> found =
        guarded.Read([&](const Map& map) { return FindNewPoints(map, keyframe, neighbour.id); });
    guarded.Write([&](Map& map) {
      for (const NewPoint& fresh : found) {
        MapPoint point;
        point.id = guarded.NewPointId();
        point.position_in_map = fresh.position_in_map;
        point.reference = keyframe;
        made.push_back(point.id);
        map.AddPoint(point);
        map.AddObservation(point.id, keyframe, fresh.keypoint_a);
        map.AddObservation(point.id, neighbour.id, fresh.keypoint_b);
        map.UpdatePointAppearance(point.id);
      }
    });
  }
  return made;
}

}  // namespace corbslam::client_agent
