#include "slam/optimisation/pose_covariance.h"

#include <cmath>
#include <map>
#include <utility>

#include "slam/optimisation/reprojection.h"
#include "slam/optimisation/scaled_inverse.h"

namespace corbslam {
namespace {

constexpr int kParameters = 6;
// With fewer rows than twice the parameters the residuals say little of the noise.
constexpr int kMinRows = 2 * kParameters;
// A direction with so much less information than the strongest, after scaling each parameter to its
// own, is not determined.
constexpr double kMinRelativeInformation = 1e-10;
// Observations in one cell of the picture, a square of this share of its width, are taken to share
// their errors.
constexpr double kCellShare = 1.0 / 24;
// With fewer cells their sums say little: observations are taken to be independent, and what
// sharing was measured to do is added (docs/lab/2026-11-27-pose-covariance.md).
constexpr size_t kMinCells = 5 * kParameters;
constexpr double kShared = 2;

struct Information {
  Matrix6d H = Matrix6d::Zero();
  double chi2 = 0;
  int rows = 0;
  // By cell: the sum of J^T W r.
  std::map<std::pair<int, int>, Vector6d> scores;
};

std::pair<int, int> CellOf(const Camera& camera, const Eigen::Vector2d& pixel) {
  const double side_px = kCellShare * camera.width_px;
  return {static_cast<int>(std::floor(pixel.x() / side_px)),
          static_cast<int>(std::floor(pixel.y() / side_px))};
}

Information Gather(const Camera& camera, const Rigid3d& camera_from_map,
                   absl::Span<const PoseObservation> inliers) {
  Information sum;
  for (const PoseObservation& o : inliers) {
    const Eigen::Vector3d x = camera_from_map * o.x_in_map;
    if (!(x.z() > kMinDepth)) continue;
    const PixelMeasurement pixel = MakeMeasurement(o.pixel, o.disparity_px, o.variance_px2);
    const Eigen::Matrix<double, 3, 6> J =
        PoseJacobian(ReprojectionJacobian(camera, x, pixel.has_depth), x);
    const Eigen::Vector3d r = ReprojectionResidual(camera, x, pixel);
    sum.H += pixel.inverse_variance * J.transpose() * J;
    sum.chi2 += pixel.inverse_variance * r.squaredNorm();
    sum.rows += pixel.has_depth ? 3 : 2;
    const auto cell = sum.scores.try_emplace(CellOf(camera, o.pixel), Vector6d::Zero()).first;
    cell->second += pixel.inverse_variance * J.transpose() * r;
  }
  return sum;
}

// Returns what stands between the two inverses of H: H scaled by the measured noise, or where there
// are cells enough the sum of their squared scores, which counts errors that neighbours share and
// those that are larger than others'.
Matrix6d Spread(const Information& sum) {
  if (sum.scores.size() < kMinCells) {
    return kShared * sum.chi2 / (sum.rows - kParameters) * sum.H;
  }
  Matrix6d spread = Matrix6d::Zero();
  for (const auto& [cell, score] : sum.scores) spread += score * score.transpose();
  const auto cells = static_cast<double>(sum.scores.size());
  return cells / (cells - kParameters) * spread;
}

}  // namespace

std::optional<Matrix6d> PoseCovariance(const Camera& camera, const Rigid3d& camera_from_map,
                                       absl::Span<const PoseObservation> inliers) {
  const Information sum = Gather(camera, camera_from_map, inliers);
  if (sum.rows < kMinRows) return std::nullopt;
  const std::optional<Matrix6d> inverse = InvertScaled(sum.H, kMinRelativeInformation);
  if (!inverse.has_value()) return std::nullopt;
  return Matrix6d(*inverse * Spread(sum) * *inverse);
}

Matrix6d InMapAxes(const Rigid3d& camera_from_map, const Matrix6d& covariance) {
  // The position is -R^T t: a translation of the camera's frame moves it by -R^T, and a rotation
  // about the camera not at all.
  const Eigen::Matrix3d turn = camera_from_map.rotation.conjugate().toRotationMatrix();
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = -turn;
  J.bottomRightCorner<3, 3>() = -turn;
  return J * covariance * J.transpose();
}

Matrix6d OfAttachedFrame(const Rigid3d& map_from_camera, const Rigid3d& camera_from_attached,
                         const Matrix6d& covariance_in_map_axes) {
  Matrix6d J = Matrix6d::Identity();
  J.topRightCorner<3, 3>() = -Skew(map_from_camera.rotation * camera_from_attached.translation);
  return J * covariance_in_map_axes * J.transpose();
}

}  // namespace corbslam
