#include "slam/camera/distortion.h"

#include <Eigen/LU>
#include <cmath>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

constexpr double kLargestCoefficient = 100;
constexpr int kMaxNewtonSteps = 20;
constexpr double kSmallestStep = 1e-12;

absl::Status CheckCoefficient(absl::string_view name, double value) {
  if (std::isfinite(value) && std::abs(value) <= kLargestCoefficient) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("distortion.", name, " is ", value,
                                                 ", must be finite and at most ",
                                                 kLargestCoefficient, " in size"));
}

double Numerator(const RadialTangential& d, double r2) {
  return 1 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
}

double Denominator(const RadialTangential& d, double r2) {
  return 1 + r2 * (d.k4 + r2 * (d.k5 + r2 * d.k6));
}

// Returns the derivative of RadialFactor by r2.
double RadialSlope(const RadialTangential& d, double r2) {
  const double above = d.k1 + r2 * (2 * d.k2 + r2 * 3 * d.k3);
  if (!d.IsRational()) return above;
  const double below = d.k4 + r2 * (2 * d.k5 + r2 * 3 * d.k6);
  const double denominator = Denominator(d, r2);
  return (above - below * Numerator(d, r2) / denominator) / denominator;
}

// Returns the derivative of Distort at `ideal`.
Eigen::Matrix2d DistortJacobian(const RadialTangential& d, const Eigen::Vector2d& ideal) {
  const double x = ideal.x();
  const double y = ideal.y();
  const double r2 = ideal.squaredNorm();
  const double radial = RadialFactor(d, r2);
  // d radial / d x is slope * x.
  const double slope = 2 * RadialSlope(d, r2);
  const double mixed = slope * x * y + 2 * d.p1 * x + 2 * d.p2 * y;
  Eigen::Matrix2d jacobian;
  jacobian << radial + slope * x * x + 2 * d.p1 * y + 6 * d.p2 * x, mixed,  //
      mixed, radial + slope * y * y + 6 * d.p1 * y + 2 * d.p2 * x;
  return jacobian;
}

}  // namespace

absl::Status Validate(const RadialTangential& distortion) {
  absl::Status status = CheckCoefficient("k1", distortion.k1);
  status.Update(CheckCoefficient("k2", distortion.k2));
  status.Update(CheckCoefficient("p1", distortion.p1));
  status.Update(CheckCoefficient("p2", distortion.p2));
  status.Update(CheckCoefficient("k3", distortion.k3));
  status.Update(CheckCoefficient("k4", distortion.k4));
  status.Update(CheckCoefficient("k5", distortion.k5));
  status.Update(CheckCoefficient("k6", distortion.k6));
  return status;
}

double RadialFactor(const RadialTangential& d, double r2) {
  return d.IsRational() ? Numerator(d, r2) / Denominator(d, r2) : Numerator(d, r2);
}

Eigen::Vector2d Distort(const RadialTangential& d, const Eigen::Vector2d& ideal) {
  const double x = ideal.x();
  const double y = ideal.y();
  const double r2 = ideal.squaredNorm();
  const double radial = RadialFactor(d, r2);
  return {x * radial + 2 * d.p1 * x * y + d.p2 * (r2 + 2 * x * x),
          y * radial + 2 * d.p2 * x * y + d.p1 * (r2 + 2 * y * y)};
}

Eigen::Vector2d Undistort(const RadialTangential& distortion, const Eigen::Vector2d& distorted) {
  if (distortion.IsZero()) return distorted;
  Eigen::Vector2d best = distorted;
  double least = (Distort(distortion, best) - distorted).norm();
  Eigen::Vector2d ideal = distorted;
  for (int i = 0; i < kMaxNewtonSteps; ++i) {
    const Eigen::Vector2d residual = Distort(distortion, ideal) - distorted;
    const Eigen::Matrix2d jacobian = DistortJacobian(distortion, ideal);
    if (!(std::abs(jacobian.determinant()) > 1e-9)) break;
    const Eigen::Vector2d step = jacobian.inverse() * residual;
    ideal -= step;
    const double error = (Distort(distortion, ideal) - distorted).norm();
    if (error < least) {
      least = error;
      best = ideal;
    }
    if (step.norm() < kSmallestStep) break;
  }
  return best;
}

}  // namespace corbslam
