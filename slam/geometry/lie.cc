#include "slam/geometry/lie.h"

#include <Eigen/LU>
#include <cmath>

namespace corbslam {
namespace {

// Below this squared angle the closed forms cancel, and the Taylor series are exact to rounding.
constexpr double kSmallAngle2 = 1e-2;

// Returns the sum over n of M^n / (n + 1)!, which is the integral of exp(s * M) over s in [0, 1].
template <typename Matrix>
Matrix IntegrateExponential(const Matrix& M) {
  constexpr int kMaxTerms = 80;
  Matrix term = Matrix::Identity();
  Matrix sum = term;
  for (int n = 1; n < kMaxTerms; ++n) {
    term = (term * M / (n + 1)).eval();
    sum += term;
    if (term.cwiseAbs().maxCoeff() < 1e-17 * sum.cwiseAbs().maxCoeff()) break;
  }
  return sum;
}

Eigen::Matrix3d LeftJacobianSO3(const Eigen::Vector3d& rotation_rad) {
  const double angle2 = rotation_rad.squaredNorm();
  const Eigen::Matrix3d W = Skew(rotation_rad);
  double a = 0.5 - angle2 / 24 + angle2 * angle2 / 720 - angle2 * angle2 * angle2 / 40320;
  double b = 1.0 / 6 - angle2 / 120 + angle2 * angle2 / 5040 - angle2 * angle2 * angle2 / 362880;
  if (angle2 > kSmallAngle2) {
    const double angle = std::sqrt(angle2);
    a = (1 - std::cos(angle)) / angle2;
    b = (angle - std::sin(angle)) / (angle2 * angle);
  }
  return Eigen::Matrix3d::Identity() + a * W + b * W * W;
}

// Returns the translation's part of the left Jacobian of SE(3) (Barfoot 2017, eq. 7.86).
Eigen::Matrix3d LeftJacobianCoupling(const Eigen::Vector3d& translation,
                                     const Eigen::Vector3d& rotation_rad) {
  const double x = rotation_rad.squaredNorm();
  double c1 = 1.0 / 6 - x / 120 + x * x / 5040 - x * x * x / 362880;
  double c2 = 1.0 / 24 - x / 720 + x * x / 40320 - x * x * x / 3628800;
  double c3 = 1.0 / 120 - x / 2520 + x * x / 120960 - x * x * x / 9979200;
  if (x > kSmallAngle2) {
    const double angle = std::sqrt(x);
    c1 = (angle - std::sin(angle)) / (x * angle);
    c2 = (x / 2 + std::cos(angle) - 1) / (x * x);
    c3 = 0.5 * (c2 + 3 * (angle - std::sin(angle) - x * angle / 6) / (x * x * angle));
  }
  const Eigen::Matrix3d P = Skew(translation);
  const Eigen::Matrix3d W = Skew(rotation_rad);
  const Eigen::Matrix3d WPW = W * P * W;
  return 0.5 * P + c1 * (W * P + P * W + WPW) + c2 * (W * W * P + P * W * W - 3 * WPW) +
         c3 * (WPW * W + W * WPW);
}

// Returns W of Strasdat 2012: exp maps the tangent's translation u to W * u.
Eigen::Matrix3d TranslationFactor(const Eigen::Vector3d& rotation_rad, double log_scale) {
  return IntegrateExponential<Eigen::Matrix3d>(Skew(rotation_rad) +
                                               log_scale * Eigen::Matrix3d::Identity());
}

}  // namespace

Eigen::Matrix3d Skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

Eigen::Quaterniond ExpSO3(const Eigen::Vector3d& rotation_rad) {
  const double angle2 = rotation_rad.squaredNorm();
  const double angle = std::sqrt(angle2);
  const double factor =
      angle2 < 1e-6 ? 0.5 - angle2 / 48 + angle2 * angle2 / 3840 : std::sin(angle / 2) / angle;
  Eigen::Quaterniond rotation;
  rotation.w() = std::cos(angle / 2);
  rotation.vec() = factor * rotation_rad;
  return rotation.normalized();
}

Eigen::Vector3d LogSO3(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0 ? -1 : 1;
  const double w = sign * rotation.w();
  const Eigen::Vector3d v = sign * rotation.vec();
  const double n = v.norm();
  // The factor is atan(n / w) / n, expanded where n vanishes.
  const double factor = n < 1e-4 ? 2 / w - 2 * n * n / (3 * w * w * w) : 2 * std::atan2(n, w) / n;
  return factor * v;
}

Rigid3d ExpSE3(const Vector6d& tangent) {
  const Eigen::Vector3d rotation = tangent.tail<3>();
  return {ExpSO3(rotation), LeftJacobianSO3(rotation) * tangent.head<3>()};
}

Vector6d LogSE3(const Rigid3d& motion) {
  Vector6d tangent;
  const Eigen::Vector3d rotation = LogSO3(motion.rotation);
  tangent << InverseLeftJacobianSO3(rotation) * motion.translation, rotation;
  return tangent;
}

Similarity3d ExpSim3(const Vector7d& tangent) {
  const Eigen::Vector3d rotation = tangent.segment<3>(3);
  return {std::exp(tangent[6]), ExpSO3(rotation),
          TranslationFactor(rotation, tangent[6]) * tangent.head<3>()};
}

Vector7d LogSim3(const Similarity3d& similarity) {
  const Eigen::Vector3d rotation = LogSO3(similarity.rotation);
  const double log_scale = std::log(similarity.scale);
  Vector7d tangent;
  tangent << TranslationFactor(rotation, log_scale).inverse() * similarity.translation, rotation,
      log_scale;
  return tangent;
}

Eigen::Matrix3d InverseLeftJacobianSO3(const Eigen::Vector3d& rotation_rad) {
  const double x = rotation_rad.squaredNorm();
  const Eigen::Matrix3d W = Skew(rotation_rad);
  double b = 1.0 / 12 + x / 720 + x * x / 30240 + x * x * x / 1209600;
  if (x > kSmallAngle2) {
    const double angle = std::sqrt(x);
    b = 1 / x - std::cos(angle / 2) / (2 * angle * std::sin(angle / 2));
  }
  return Eigen::Matrix3d::Identity() - 0.5 * W + b * W * W;
}

Matrix6d InverseLeftJacobianSE3(const Vector6d& tangent) {
  const Eigen::Matrix3d J = InverseLeftJacobianSO3(tangent.tail<3>());
  Matrix6d result = Matrix6d::Zero();
  result.topLeftCorner<3, 3>() = J;
  result.bottomRightCorner<3, 3>() = J;
  result.topRightCorner<3, 3>() =
      -J * LeftJacobianCoupling(tangent.head<3>(), tangent.tail<3>()) * J;
  return result;
}

Matrix7d InverseLeftJacobianSim3(const Vector7d& tangent) {
  Matrix7d ad = Matrix7d::Zero();
  const Eigen::Matrix3d W = Skew(tangent.segment<3>(3));
  ad.topLeftCorner<3, 3>() = W + tangent[6] * Eigen::Matrix3d::Identity();
  ad.block<3, 3>(0, 3) = Skew(tangent.head<3>());
  ad.block<3, 1>(0, 6) = -tangent.head<3>();
  ad.block<3, 3>(3, 3) = W;
  return IntegrateExponential<Matrix7d>(ad).inverse();
}

Matrix6d AdjointSE3(const Rigid3d& motion) {
  const Eigen::Matrix3d R = motion.rotation.toRotationMatrix();
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = R;
  adjoint.bottomRightCorner<3, 3>() = R;
  adjoint.topRightCorner<3, 3>() = Skew(motion.translation) * R;
  return adjoint;
}

Matrix7d AdjointSim3(const Similarity3d& similarity) {
  const Eigen::Matrix3d R = similarity.rotation.toRotationMatrix();
  Matrix7d adjoint = Matrix7d::Zero();
  adjoint.topLeftCorner<3, 3>() = similarity.scale * R;
  adjoint.block<3, 3>(0, 3) = Skew(similarity.translation) * R;
  adjoint.block<3, 1>(0, 6) = -similarity.translation;
  adjoint.block<3, 3>(3, 3) = R;
  adjoint(6, 6) = 1;
  return adjoint;
}

}  // namespace corbslam
