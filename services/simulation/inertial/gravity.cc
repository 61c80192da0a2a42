#include "services/simulation/inertial/gravity.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/geometry/lie.h"
#include "slam/util/text_file.h"

namespace corbslam {
namespace {

constexpr int64_t kWindow_ns = 500'000'000;
constexpr int64_t kLongestGap_ns = 50'000'000;

// Over one window: change of velocity = sum_of_forces - turned * bias + duration * gravity.
struct Window {
  double duration_s = 0;
  Eigen::Vector3d velocity_change = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum_of_forces = Eigen::Vector3d::Zero();
  Eigen::Matrix3d turned = Eigen::Matrix3d::Zero();
};

using Unknowns = Vector6d;  // Gravity, bias of the accelerometer.

Eigen::Matrix<double, 3, 6> JacobianOf(const Window& window) {
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian << window.duration_s * Eigen::Matrix3d::Identity(), -window.turned;
  return jacobian;
}

void AddStep(const ImuMotion& motion, const ImuSample& from, const ImuSample& to, Window& window) {
  const int64_t step_ns = to.timestamp_ns - from.timestamp_ns;
  const double step_s = 1e-9 * static_cast<double>(step_ns);
  const Eigen::Matrix3d rotation =
      motion(from.timestamp_ns + step_ns / 2).rotation.toRotationMatrix();
  window.duration_s += step_s;
  window.sum_of_forces +=
      step_s * (rotation * (0.5 * (from.specific_force_mps2 + to.specific_force_mps2)));
  window.turned += step_s * rotation;
}

std::vector<Window> CutIntoWindows(const ImuMotion& motion, const TimeSpan& span,
                                   const ImuSamples& samples) {
  std::vector<Window> windows;
  Window window;
  const ImuSample* first = nullptr;
  for (size_t i = 0; i + 1 < samples.size(); ++i) {
    const ImuSample& to = samples[i + 1];
    const bool usable = samples[i].timestamp_ns >= span.first_ns &&
                        to.timestamp_ns <= span.last_ns &&
                        to.timestamp_ns - samples[i].timestamp_ns <= kLongestGap_ns;
    if (!usable) {
      first = nullptr;
      continue;
    }
    if (first == nullptr) {
      first = &samples[i];
      window = {};
    }
    AddStep(motion, samples[i], to, window);
    if (to.timestamp_ns - first->timestamp_ns < kWindow_ns) continue;
    window.velocity_change =
        VelocityAt(motion, span, to.timestamp_ns) - VelocityAt(motion, span, first->timestamp_ns);
    windows.push_back(window);
    first = nullptr;
  }
  return windows;
}

Unknowns Fit(const std::vector<Window>& windows) {
  // A bias is known to be less than this, about, where the flight does not turn enough to show it.
  constexpr double kBias_mps2 = 0.3;
  constexpr double kVelocity_mps = 0.01;
  Matrix6d normal = Matrix6d::Zero();
  normal.bottomRightCorner<3, 3>().diagonal().setConstant(std::pow(kVelocity_mps / kBias_mps2, 2));
  Unknowns right = Unknowns::Zero();
  for (const Window& window : windows) {
    const auto jacobian = JacobianOf(window);
    normal += jacobian.transpose() * jacobian;
    right += jacobian.transpose() * (window.velocity_change - window.sum_of_forces);
  }
  return normal.ldlt().solve(right);
}

// Returns by how much accelerations of the samples and of the motion differ, m/s2.
double MisfitOf(const std::vector<Window>& windows, const Unknowns& fitted) {
  double squares = 0;
  for (const Window& window : windows) {
    squares += ((JacobianOf(window) * fitted + window.sum_of_forces - window.velocity_change) /
                window.duration_s)
                   .squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(windows.size()));
}

}  // namespace

absl::StatusOr<Eigen::Vector3d> EstimateGravity(const ImuMotion& motion, const TimeSpan& span,
                                                const ImuSamples& samples) {
  constexpr size_t kFewestWindows = 6;
  constexpr double kWrongLength_mps2 = 0.2;
  constexpr double kWrongMotion_mps2 = 0.25;
  const std::vector<Window> windows = CutIntoWindows(motion, span, samples);
  if (windows.size() < kFewestWindows) {
    return absl::InvalidArgumentError(absl::StrCat(
        "less than three seconds of the IMU's samples are of the time of the poses, which is ",
        FormatReal(1e-9 * static_cast<double>(span.first_ns)), " to ",
        FormatReal(1e-9 * static_cast<double>(span.last_ns)), " s"));
  }
  const Unknowns fitted = Fit(windows);
  const Eigen::Vector3d gravity = fitted.head<3>();
  const double misfit_mps2 = MisfitOf(windows, fitted);
  if (std::abs(gravity.norm() - kGravity_mps2) > kWrongLength_mps2 ||
      !(misfit_mps2 < kWrongMotion_mps2)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the IMU's samples are not of the poses' motion: gravity comes out as ",
        FormatReal(gravity.norm()), " m/s2 (", FormatReal(kGravity_mps2),
        "), accelerations differ by ", FormatReal(misfit_mps2), " m/s2 (at most ",
        FormatReal(kWrongMotion_mps2), "); poses must be those of the IMU itself, by its clock"));
  }
  return gravity;
}

}  // namespace corbslam
