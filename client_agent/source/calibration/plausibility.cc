#include "client_agent/source/calibration/plausibility.h"

#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"

namespace corbslam::client_agent {
namespace {

// One number of a calibration: what it is, and between which bounds it must and should be.
struct Judged {
  std::string what;
  double value;
  double least, low, high, most;
  absl::string_view advice;
  bool is_nothing = false;  // No camera has it, whatever one trusts: no number, or not above 0.
};

constexpr absl::string_view kOtherSize =
    "are these numbers of pictures of another size, or in another order?";
constexpr absl::string_view kOtherUnit = "is it in metres?";
constexpr absl::string_view kOtherNoise =
    "is it a density, for rad/s and m/s2 and the square root of 1 Hz, and no other field's?";

// Judges a principal point by shares of a side. Pictures at half or twice the size of their
// calibration are at 1 and 0.25, those at three quarters at 0.67; of the public recordings the
// farthest off is at 0.41.
Judged PrincipalPoint(absl::string_view name, double c_px, int side_px) {
  return {absl::StrCat(name, " ", c_px, " px of ", side_px),
          c_px / side_px,
          0.3,
          0.35,
          0.65,
          0.7,
          kOtherSize,
          !std::isfinite(c_px) || side_px <= 0};
}

// Judges a focal length by the wider side: 0.25 sees 127 degrees, 4 sees 14.
Judged FocalLength(absl::string_view name, double f_px, int side_px) {
  return {absl::StrCat(name, " ", f_px, " px with ", side_px, " px of width"),
          f_px / side_px,
          0.1,
          0.25,
          4,
          20,
          kOtherSize,
          !(f_px > 0) || !std::isfinite(f_px) || side_px <= 0};
}

absl::StatusOr<SourceFindings> Judge(const std::vector<Judged>& numbers, absl::string_view from,
                                     bool trust) {
  SourceFindings findings;
  for (const Judged& j : numbers) {
    if (j.is_nothing) {
      return absl::InvalidArgumentError(
          absl::StrCat(from, ": ", j.what, " can't be: must be finite and above 0"));
    }
    if (j.value >= j.low && j.value <= j.high) continue;
    const bool possible = j.value >= j.least && j.value <= j.most;
    const std::string text =
        absl::StrCat(from, ": ", j.what, possible ? " is improbable: " : " can't be: ", j.advice);
    if (!possible && !trust) {
      return absl::InvalidArgumentError(
          absl::StrCat(text, " If it is right, say ?trust-calibration"));
    }
    findings.push_back({FindingLevel::kWarning, "calibration-improbable", text});
  }
  return findings;
}

}  // namespace

absl::StatusOr<SourceFindings> CheckIntrinsics(const Intrinsics& intrinsics, absl::string_view from,
                                               bool trust) {
  const Intrinsics& k = intrinsics;
  return Judge({FocalLength("fx", k.fx_px, k.width_px),
                FocalLength("fy", k.fy_px, k.width_px),
                {absl::StrCat("fx ", k.fx_px, " px beside fy ", k.fy_px, " px"), k.fx_px / k.fy_px,
                 0.5, 0.9, 1.12, 2, kOtherSize},
                PrincipalPoint("cx", k.cx_px, k.width_px),
                PrincipalPoint("cy", k.cy_px, k.height_px)},
               from, trust);
}

absl::StatusOr<SourceFindings> CheckBaseline(double baseline_m, absl::string_view from,
                                             bool trust) {
  return Judge({{absl::StrCat("a baseline of ", baseline_m, " m"), baseline_m, 0.005, 0.02, 2, 5,
                 kOtherUnit, !(baseline_m > 0) || !std::isfinite(baseline_m)}},
               from, trust);
}

absl::StatusOr<SourceFindings> CheckImuNumbers(const StatedImu& imu, absl::string_view from,
                                               bool trust) {
  std::vector<Judged> numbers;
  const auto add = [&](absl::string_view what, std::optional<double> value, double least,
                       double low, double high, double most, absl::string_view advice) {
    if (!value.has_value()) return;
    numbers.push_back({absl::StrCat("imu: ", what, " of ", *value), *value, least, low, high, most,
                       advice, !(*value > 0) || !std::isfinite(*value)});
  };
  add("a rate_hz", imu.rate_hz, 1, 50, 2500, 20'000, "is it in Hz, and the IMU's?");
  // From a fibre-optic gyroscope to the noise that estimators of cheap ones are tuned to.
  add("a gyro_noise", imu.gyro_noise, 1e-9, 1e-7, 0.06, 1, kOtherNoise);
  add("an accel_noise", imu.accel_noise, 1e-8, 1e-6, 0.6, 10, kOtherNoise);
  add("a gyro_walk", imu.gyro_walk, 1e-14, 1e-10, 1e-2, 1, kOtherNoise);
  add("an accel_walk", imu.accel_walk, 1e-13, 1e-9, 0.2, 10, kOtherNoise);
  return Judge(numbers, from, trust);
}

}  // namespace corbslam::client_agent
