#include "slam/solvers/absolute_orientation.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

// If the second spread is a smaller share of the largest one, it counts as none: the points are on
// a line.
constexpr double kMinSpreadShare = 1e-10;

struct Moments {
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_b = Eigen::Vector3d::Zero();
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();         // Sum of a * b^T, which is Horn's M.
  Eigen::Matrix3d spread_a = Eigen::Matrix3d::Zero();  // Sum of a * a^T.
  Eigen::Matrix3d spread_b = Eigen::Matrix3d::Zero();
};

Moments ComputeMoments(absl::Span<const Eigen::Vector3d> points_a,
                       absl::Span<const Eigen::Vector3d> points_b) {
  Moments m;
  for (size_t i = 0; i < points_a.size(); ++i) {
    m.mean_a += points_a[i];
    m.mean_b += points_b[i];
  }
  m.mean_a /= static_cast<double>(points_a.size());
  m.mean_b /= static_cast<double>(points_b.size());
  for (size_t i = 0; i < points_a.size(); ++i) {
    const Eigen::Vector3d a = points_a[i] - m.mean_a;
    const Eigen::Vector3d b = points_b[i] - m.mean_b;
    m.M += a * b.transpose();
    m.spread_a += a * a.transpose();
    m.spread_b += b * b.transpose();
  }
  return m;
}

bool IsOnALine(const Eigen::Matrix3d& spread) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread, Eigen::EigenvaluesOnly);
  return !(solver.eigenvalues()[1] > kMinSpreadShare * solver.eigenvalues()[2]);
}

// Returns the eigenvector of N's largest eigenvalue, which is the quaternion (Horn 1987, 4.A).
Eigen::Quaterniond BestRotation(const Eigen::Matrix3d& M) {
  Eigen::Matrix4d N;
  const Eigen::Vector3d skew(M(1, 2) - M(2, 1), M(2, 0) - M(0, 2), M(0, 1) - M(1, 0));
  N(0, 0) = M.trace();
  N.topRightCorner<1, 3>() = skew.transpose();
  N.bottomLeftCorner<3, 1>() = skew;
  N.bottomRightCorner<3, 3>() = M + M.transpose() - M.trace() * Eigen::Matrix3d::Identity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(N);
  const Eigen::Vector4d q = solver.eigenvectors().col(3);
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
}

}  // namespace

absl::StatusOr<Similarity3d> AlignPoints(absl::Span<const Eigen::Vector3d> points_a,
                                         absl::Span<const Eigen::Vector3d> points_b,
                                         bool fix_scale) {
  if (points_a.size() != points_b.size() || points_a.size() < 3) {
    return absl::InvalidArgumentError(absl::StrCat("align points: ", points_a.size(), " and ",
                                                   points_b.size(),
                                                   " points, need as many of both, at least 3"));
  }
  const Moments m = ComputeMoments(points_a, points_b);
  if (!m.M.allFinite() || !m.spread_a.allFinite() || !m.spread_b.allFinite()) {
    return absl::InvalidArgumentError("align points: a point is not finite");
  }
  if (IsOnALine(m.spread_a) || IsOnALine(m.spread_b)) {
    return absl::InvalidArgumentError("align points: the points lie on a line");
  }
  Similarity3d b_from_a;
  b_from_a.rotation = BestRotation(m.M);
  if (!fix_scale) b_from_a.scale = std::sqrt(m.spread_b.trace() / m.spread_a.trace());
  b_from_a.translation = m.mean_b - b_from_a.scale * (b_from_a.rotation * m.mean_a);
  return b_from_a;
}

}  // namespace corbslam
