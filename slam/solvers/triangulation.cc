#include "slam/solvers/triangulation.h"

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

// Squared sine of the angle between rays that count as parallel (about 0.0006 degrees).
constexpr double kMinSine2 = 1e-10;

Eigen::Vector3d RayOf(const Camera& camera, const Eigen::Vector2d& pixel) {
  return Unproject(camera, pixel.x(), pixel.y(), 1.0);
}

}  // namespace

std::optional<TriangulatedPoint> TriangulatePoint(
    const Camera& camera_1, const Rigid3d& camera_1_from_map, const Eigen::Vector2d& pixel_1,
    const Camera& camera_2, const Rigid3d& camera_2_from_map, const Eigen::Vector2d& pixel_2) {
  const Rigid3d two_from_one = camera_2_from_map * camera_1_from_map.Inverse();
  // Unit rays in camera 2's frame; t is camera 1's centre there.
  const Eigen::Vector3d ray_1 = two_from_one.rotation * RayOf(camera_1, pixel_1).normalized();
  const Eigen::Vector3d ray_2 = RayOf(camera_2, pixel_2).normalized();
  const Eigen::Vector3d& t = two_from_one.translation;
  const Eigen::Vector3d p = ray_1.cross(ray_2);
  const double sine2 = p.squaredNorm();
  if (!(sine2 > kMinSine2)) return std::nullopt;
  const Eigen::Vector3d q = ray_1.cross(t);
  const Eigen::Vector3d r = ray_2.cross(t);
  // Distances along both rays to each other's nearest point. Their signs come from the plain
  // midpoint's solution, so that rays that part are seen to.
  const double along_1 = r.dot(p) / sine2;
  const double along_2 = q.dot(p) / sine2;
  if (!(along_1 > 0 && along_2 > 0)) return std::nullopt;
  const double q_norm = q.norm();
  const double r_norm = r.norm();
  if (!(q_norm + r_norm > 0)) return std::nullopt;
  // Lee and Civera 2019, eq. 11: weights are the inverse depths |p| / |r| and |p| / |q|.
  const double p_norm = std::sqrt(sine2);
  const Eigen::Vector3d x_in_2 =
      (q_norm * (t + r_norm / p_norm * ray_1) + r_norm * (q_norm / p_norm * ray_2)) /
      (q_norm + r_norm);
  TriangulatedPoint point;
  point.x_in_map = camera_2_from_map.Inverse() * x_in_2;
  point.parallax_cosine = std::clamp(ray_1.dot(ray_2), -1.0, 1.0);
  point.depth_1 = (camera_1_from_map * point.x_in_map).z();
  point.depth_2 = x_in_2.z();
  if (!(point.depth_1 > 0 && point.depth_2 > 0)) return std::nullopt;
  return point;
}

}  // namespace corbslam
