#include "slam/inertial/imu_axes.h"

#include <Eigen/SVD>
#include <cmath>

#include "absl/strings/str_format.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr size_t kMostFrames = 200;
constexpr size_t kLeastFrames = 20;
// Turning that pictures measure well, rms over the frames; and the share of it that must be about a
// second axis for the rotation to be told.
constexpr double kLeastTurning_rps = 0.05;
constexpr double kLeastSecond = 0.1;
// A fit is right where less is left over, and a calibration wrong where it leaves more.
constexpr double kRight = 0.3;
constexpr double kWrong = 0.6;
constexpr double kDegrees = 180 / M_PI;

}  // namespace

void ImuAxes::Add(const Vector3d& by_camera_rps, const Vector3d& by_imu_rps) {
  rates_.push_back({by_camera_rps, by_imu_rps});
  if (rates_.size() > kMostFrames) rates_.pop_front();
}

std::optional<AxesFit> ImuAxes::Fit() const {
  if (rates_.size() < kLeastFrames) return std::nullopt;
  // A gyroscope's bias is no turning of the camera's.
  Vector3d camera_mean = Vector3d::Zero();
  Vector3d imu_mean = Vector3d::Zero();
  for (const Rates& rates : rates_) {
    camera_mean += rates.by_camera;
    imu_mean += rates.by_imu;
  }
  const auto count = static_cast<double>(rates_.size());
  camera_mean /= count;
  imu_mean /= count;
  Matrix3d cross = Matrix3d::Zero();
  Matrix3d camera_spread = Matrix3d::Zero();
  double imu_square = 0;
  double differences = 0;
  for (const Rates& rates : rates_) {
    const Vector3d camera = rates.by_camera - camera_mean;
    const Vector3d imu = rates.by_imu - imu_mean;
    cross += camera * imu.transpose();
    camera_spread += camera * camera.transpose();
    imu_square += imu.squaredNorm();
    differences += (camera - imu).squaredNorm();
  }
  const double camera_square = camera_spread.trace();
  if (camera_square < count * kLeastTurning_rps * kLeastTurning_rps) return std::nullopt;
  const Vector3d about = Eigen::JacobiSVD<Matrix3d>(camera_spread).singularValues().cwiseSqrt();
  if (about(1) < kLeastSecond * about(0)) return std::nullopt;
  const Eigen::JacobiSVD<Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d sign = Matrix3d::Identity();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) sign(2, 2) = -1;
  AxesFit fit;
  fit.camera_from_imu = Eigen::Quaterniond(svd.matrixU() * sign * svd.matrixV().transpose());
  const double along = (svd.singularValues().asDiagonal() * sign).trace();
  fit.scale = imu_square > 0 ? along / imu_square : 0;
  fit.left_over = std::sqrt(std::max(0.0, 1 - fit.scale * along / camera_square));
  fit.left_over_as_calibrated = std::min(1.0, std::sqrt(differences / camera_square));
  return fit;
}

std::optional<std::string> ImuAxes::Describe(const AxesFit& fit) {
  if (fit.left_over_as_calibrated < kWrong) return std::nullopt;
  if (fit.left_over > kRight) {
    return absl::StrFormat(
        "the IMU does not turn as the camera does, whatever its axes are (%.0f %% of the camera's "
        "turning is left over): its clock may be another, or it sits on something else",
        100 * fit.left_over);
  }
  if (std::abs(fit.scale - 1) > 0.2) {
    const bool is_degrees = std::abs(fit.scale * kDegrees - 1) < 0.2;
    return absl::StrFormat("the IMU turns %.3g times as fast as the camera%s", 1 / fit.scale,
                           is_degrees ? ": are its rates in degrees a second? Radians are meant"
                                      : ": is the scale of its gyroscope right?");
  }
  const Eigen::AngleAxisd turn(fit.camera_from_imu);
  return absl::StrFormat(
      "the IMU's axes are turned by %.0f degrees about (%.2f, %.2f, %.2f) of its own against what "
      "imu_from_camera says: are axes exchanged, or is the matrix the inverse?",
      turn.angle() * kDegrees, turn.axis().x(), turn.axis().y(), turn.axis().z());
}

}  // namespace corbslam
