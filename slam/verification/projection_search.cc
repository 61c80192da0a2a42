#include "slam/verification/projection_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "slam/camera/camera.h"

namespace corbslam {
namespace {

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();
// Tolerance on the range of distances, and the widest angle to the mean direction (60 degrees).
constexpr double kRangeMargin = 1.25;
constexpr double kMinCosine = 0.5;

struct Expectation {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double depth = 0;
  int min_octave = 0;
  int max_octave = ScalePyramid::kLevels - 1;
  double radius_px = 0;
};

std::optional<Expectation> Expect(const MapPoint& point, const Camera& camera,
                                  const Rigid3d& camera_from_points,
                                  const Eigen::Vector3d& centre_in_points,
                                  const ProjectionSearchOptions& options) {
  const Eigen::Vector3d x_in_camera = camera_from_points * point.position_in_map;
  if (x_in_camera.z() <= 0) return std::nullopt;
  Expectation expected{.pixel = Project(camera, x_in_camera), .depth = x_in_camera.z()};
  if (!IsInImage(camera, expected.pixel)) return std::nullopt;
  const Eigen::Vector3d ray = point.position_in_map - centre_in_points;
  const double distance = ray.norm();
  if (point.normal_in_map.dot(ray) < kMinCosine * distance * point.normal_in_map.norm()) {
    return std::nullopt;
  }
  int octave = 0;
  if (point.max_distance > 0) {
    if (distance > kRangeMargin * point.max_distance) return std::nullopt;
    if (distance * kRangeMargin < point.min_distance) return std::nullopt;
    octave = ScalePyramid::PredictOctave(point.max_distance, distance);
    expected.min_octave = octave - 1;
    expected.max_octave = octave + 1;
  }
  expected.radius_px = options.radius_px * ScalePyramid::Scale(octave);
  expected.pixel += expected.radius_px * options.displacement_radii;
  return expected;
}

bool DisparityAgrees(const Keypoint& keypoint, const Camera& camera, const Expectation& expected) {
  if (!keypoint.HasDepth() || !camera.IsMetric()) return true;
  const double disparity_px = DisparityFromDepth(camera, expected.depth);
  return std::abs(disparity_px - static_cast<double>(keypoint.disparity_px)) < expected.radius_px;
}

struct Best {
  uint32_t keypoint = kNone;
  int distance = 257;
};

Best FindBest(const MapPoint& point, const Keyframe& keyframe, const Expectation& expected,
              const ProjectionSearchOptions& options, std::vector<uint32_t>& near) {
  near.clear();
  keyframe.payload->grid.FindNear(keyframe.keypoints(), expected.pixel.x(), expected.pixel.y(),
                                  expected.radius_px, expected.min_octave, expected.max_octave,
                                  near);
  Best best;
  for (const uint32_t i : near) {
    if (i >= keyframe.descriptors().size()) continue;
    if (options.only_keypoints_with_points && !keyframe.points[i].IsValid()) continue;
    if (options.check_disparity &&
        !DisparityAgrees(keyframe.keypoints()[i], keyframe.camera(), expected)) {
      continue;
    }
    const int distance = HammingDistance(point.descriptor, keyframe.descriptors()[i]);
    if (distance < best.distance) best = {i, distance};
  }
  if (best.distance > options.max_distance) return {};
  return best;
}

// Returns how many points are found in each of the windows beside where they should be, without a
// gap.
std::array<size_t, 4> CountAside(const std::vector<const MapPoint*>& points,
                                 const Keyframe& keyframe, const Rigid3d& camera_from_points,
                                 ProjectionSearchOptions options) {
  constexpr double kAside = 2.0;
  const std::array<Eigen::Vector2d, 4> sides = {
      Eigen::Vector2d(kAside, 0), Eigen::Vector2d(-kAside, 0), Eigen::Vector2d(0, kAside),
      Eigen::Vector2d(0, -kAside)};
  std::array<size_t, 4> counts = {};
  for (size_t i = 0; i < sides.size(); ++i) {
    options.displacement_radii = sides[i];
    counts[i] = FindByProjection(points, keyframe, camera_from_points, options).size();
  }
  return counts;
}

}  // namespace

std::vector<ProjectionMatch> FindByProjection(const std::vector<const MapPoint*>& points,
                                              const Keyframe& keyframe,
                                              const Rigid3d& camera_from_points,
                                              const ProjectionSearchOptions& options) {
  const Eigen::Vector3d centre = CameraCentre(camera_from_points);
  std::vector<ProjectionMatch> of_keypoint(keyframe.keypoints().size(), {kNone, kNone, 257});
  std::vector<uint32_t> near;
  for (uint32_t i = 0; i < points.size(); ++i) {
    const auto expected =
        Expect(*points[i], keyframe.camera(), camera_from_points, centre, options);
    if (!expected.has_value()) continue;
    const Best best = FindBest(*points[i], keyframe, *expected, options, near);
    if (best.keypoint == kNone) continue;
    ProjectionMatch& match = of_keypoint[best.keypoint];
    if (best.distance < match.distance) match = {i, best.keypoint, best.distance};
  }
  std::erase_if(of_keypoint, [](const ProjectionMatch& match) { return match.point == kNone; });
  return of_keypoint;
}

size_t CountByChance(const std::vector<const MapPoint*>& points, const Keyframe& keyframe,
                     const Rigid3d& camera_from_points, ProjectionSearchOptions options) {
  const std::array<size_t, 4> aside = CountAside(points, keyframe, camera_from_points, options);
  return *std::max_element(aside.begin(), aside.end());
}

size_t MeanByChance(const std::vector<const MapPoint*>& points, const Keyframe& keyframe,
                    const Rigid3d& camera_from_points, ProjectionSearchOptions options) {
  const std::array<size_t, 4> aside = CountAside(points, keyframe, camera_from_points, options);
  return (std::accumulate(aside.begin(), aside.end(), size_t{0}) + aside.size() - 1) / aside.size();
}

size_t CountVisible(const std::vector<const MapPoint*>& points, const Keyframe& keyframe,
                    const Rigid3d& camera_from_points) {
  const Eigen::Vector3d centre = CameraCentre(camera_from_points);
  return static_cast<size_t>(
      std::count_if(points.begin(), points.end(), [&](const MapPoint* point) {
        return Expect(*point, keyframe.camera(), camera_from_points, centre, {}).has_value();
      }));
}

}  // namespace corbslam
