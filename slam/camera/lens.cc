#include "slam/camera/lens.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

constexpr double kLargestCoefficient = 100;
constexpr double kLargestXi = 10;
// A direction is found when it falls this near to where it should, in focal lengths.
constexpr double kInverted = 1e-9;
constexpr double kAngleStep_rad = std::numbers::pi / 128;
constexpr int kMaxSteps = 60;
// The least z of a unit vector that a pinhole's picture shows: 80 degrees from its axis.
constexpr double kLeastPinholeZ = 0.174;

absl::Status CheckRange(absl::string_view name, double value, double least, double most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("lens: ", name, " is ", value, ", must be in [", least, ", ", most, "]"));
}

absl::Status Check(const RadialTangential& lens) { return Validate(lens); }

absl::Status Check(const Equidistant& lens) {
  absl::Status status = CheckRange("k1", lens.k1, -kLargestCoefficient, kLargestCoefficient);
  status.Update(CheckRange("k2", lens.k2, -kLargestCoefficient, kLargestCoefficient));
  status.Update(CheckRange("k3", lens.k3, -kLargestCoefficient, kLargestCoefficient));
  status.Update(CheckRange("k4", lens.k4, -kLargestCoefficient, kLargestCoefficient));
  return status;
}

absl::Status Check(const DoubleSphere& lens) {
  absl::Status status = CheckRange("xi", lens.xi, -1, 1);
  status.Update(CheckRange("alpha", lens.alpha, 0, 1));
  return status;
}

absl::Status Check(const UnifiedSphere& lens) {
  RETURN_IF_ERROR(CheckRange("xi", lens.xi, 0, kLargestXi));
  return Validate(lens.distortion);
}

using Seen = std::optional<Eigen::Vector2d>;
using Direction = std::optional<Eigen::Vector3d>;

// Returns true if the lens grows from the middle up to the ideal point, so that no other point
// nearer to the middle falls at the same place.
bool IsBeforeTheFold(const RadialTangential& lens, const Eigen::Vector2d& ideal) {
  constexpr int kSamples = 16;
  double before = 0;
  for (int i = 1; i <= kSamples; ++i) {
    const double r = ideal.norm() * i / kSamples;
    const double seen = r * RadialFactor(lens, r * r);
    if (!(seen > before)) return false;
    before = seen;
  }
  return true;
}

Seen Through(const RadialTangential& lens, const Eigen::Vector3d& direction) {
  if (!(direction.z() > 0)) return std::nullopt;
  const Eigen::Vector2d ideal = direction.head<2>() / direction.z();
  if (lens.IsZero()) return ideal;
  if (!ideal.isZero(0) && !IsBeforeTheFold(lens, ideal)) return std::nullopt;
  return Distort(lens, ideal);
}

Direction Behind(const RadialTangential& lens, const Eigen::Vector2d& seen) {
  const Eigen::Vector2d ideal = Undistort(lens, seen);
  if (!((Distort(lens, ideal) - seen).norm() < kInverted)) return std::nullopt;
  if (!lens.IsZero() && !ideal.isZero(0) && !IsBeforeTheFold(lens, ideal)) return std::nullopt;
  return Eigen::Vector3d(ideal.x(), ideal.y(), 1).normalized();
}

double RadiusAt(const Equidistant& lens, double angle) {
  const double a2 = angle * angle;
  return angle * (1 + a2 * (lens.k1 + a2 * (lens.k2 + a2 * (lens.k3 + a2 * lens.k4))));
}

double SlopeAt(const Equidistant& lens, double angle) {
  const double a2 = angle * angle;
  return 1 + a2 * (3 * lens.k1 + a2 * (5 * lens.k2 + a2 * (7 * lens.k3 + a2 * 9 * lens.k4)));
}

// Returns true if the radius grows with the angle up to this one.
bool IsBeforeTheFold(const Equidistant& lens, double angle) {
  for (double a = angle; a > 0; a -= kAngleStep_rad) {
    if (!(SlopeAt(lens, a) > 0)) return false;
  }
  return true;
}

Seen Through(const Equidistant& lens, const Eigen::Vector3d& direction) {
  const double across = direction.head<2>().norm();
  const double angle = std::atan2(across, direction.z());
  if (!IsBeforeTheFold(lens, angle)) return std::nullopt;
  if (across == 0) {
    return direction.z() > 0 ? Seen(Eigen::Vector2d(0, 0)) : std::nullopt;
  }
  return Eigen::Vector2d(direction.head<2>() * (RadiusAt(lens, angle) / across));
}

// Returns the angle that falls at `radius`, by bisection between steps within which the radius
// grows.
std::optional<double> AngleAt(const Equidistant& lens, double radius) {
  double low = 0;
  double high = 0;
  while (RadiusAt(lens, high) < radius) {
    low = high;
    high += kAngleStep_rad;
    if (high > std::numbers::pi || !(SlopeAt(lens, high) > 0)) return std::nullopt;
  }
  for (int i = 0; i < kMaxSteps; ++i) {
    const double middle = 0.5 * (low + high);
    (RadiusAt(lens, middle) < radius ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Direction Behind(const Equidistant& lens, const Eigen::Vector2d& seen) {
  const double radius = seen.norm();
  if (radius == 0) return Eigen::Vector3d(0, 0, 1);
  const std::optional<double> angle = AngleAt(lens, radius);
  if (!angle.has_value()) return std::nullopt;
  const Eigen::Vector2d across = seen * (std::sin(*angle) / radius);
  return Eigen::Vector3d(across.x(), across.y(), std::cos(*angle));
}

// Usenko et al., equations 40 to 45.
Seen Through(const DoubleSphere& lens, const Eigen::Vector3d& direction) {
  const auto [xi, alpha] = lens;
  const Eigen::Vector3d ray = direction.normalized();
  const double w1 = alpha > 0.5 ? (1 - alpha) / alpha : alpha / (1 - alpha);
  const double w2 = (w1 + xi) / std::sqrt(2 * w1 * xi + xi * xi + 1);
  if (!(ray.z() > -w2)) return std::nullopt;
  const double lifted = xi + ray.z();
  const double from_second = std::hypot(ray.x(), ray.y(), lifted);
  const double depth = alpha * from_second + (1 - alpha) * lifted;
  if (!(depth > 0)) return std::nullopt;
  return Eigen::Vector2d(ray.head<2>() / depth);
}

// Usenko et al., equations 46 to 51.
Direction Behind(const DoubleSphere& lens, const Eigen::Vector2d& seen) {
  const auto [xi, alpha] = lens;
  const double r2 = seen.squaredNorm();
  const double inner = 1 - (2 * alpha - 1) * r2;
  if (!(inner >= 0)) return std::nullopt;
  const double mz = (1 - alpha * alpha * r2) / (alpha * std::sqrt(inner) + 1 - alpha);
  const double outer = mz * mz + (1 - xi * xi) * r2;
  if (!(outer >= 0)) return std::nullopt;
  const double factor = (mz * xi + std::sqrt(outer)) / (mz * mz + r2);
  return Eigen::Vector3d(factor * seen.x(), factor * seen.y(), factor * mz - xi).normalized();
}

Seen Through(const UnifiedSphere& lens, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d ray = direction.normalized();
  const double lifted = ray.z() + lens.xi;
  // Behind this, rays fall where others do.
  const double least_z = lens.xi > 1 ? -1 / lens.xi : -lens.xi;
  if (!(ray.z() > least_z) || !(lifted > 0)) return std::nullopt;
  return Through(lens.distortion, {ray.x(), ray.y(), lifted});
}

Direction Behind(const UnifiedSphere& lens, const Eigen::Vector2d& seen) {
  const Direction pinhole = Behind(lens.distortion, seen);
  if (!pinhole.has_value()) return std::nullopt;
  const Eigen::Vector2d m = pinhole->head<2>() / pinhole->z();
  const double r2 = m.squaredNorm();
  const double inner = 1 + (1 - lens.xi * lens.xi) * r2;
  if (!(inner >= 0)) return std::nullopt;
  const double factor = (lens.xi + std::sqrt(inner)) / (r2 + 1);
  return Eigen::Vector3d(factor * m.x(), factor * m.y(), factor - lens.xi).normalized();
}

std::string TextOf(const RadialTangential& lens) {
  if (lens.IsZero()) return "no distortion";
  std::string text = absl::StrCat("radial-tangential distortion k1 ", lens.k1, " k2 ", lens.k2,
                                  " p1 ", lens.p1, " p2 ", lens.p2, " k3 ", lens.k3);
  if (lens.IsRational()) {
    absl::StrAppend(&text, " k4 ", lens.k4, " k5 ", lens.k5, " k6 ", lens.k6);
  }
  return text;
}

std::string TextOf(const Equidistant& lens) {
  return absl::StrCat("equidistant fisheye k1 ", lens.k1, " k2 ", lens.k2, " k3 ", lens.k3, " k4 ",
                      lens.k4);
}

std::string TextOf(const DoubleSphere& lens) {
  return absl::StrCat("double sphere xi ", lens.xi, " alpha ", lens.alpha);
}

std::string TextOf(const UnifiedSphere& lens) {
  return absl::StrCat("unified sphere xi ", lens.xi, ", ", TextOf(lens.distortion));
}

}  // namespace

absl::Status Validate(const LensModel& model) {
  return std::visit([](const auto& lens) { return Check(lens); }, model);
}

absl::string_view NameOf(const LensModel& model) {
  constexpr absl::string_view kNames[] = {"radial-tangential", "equidistant", "double-sphere",
                                          "unified"};
  return kNames[model.index()];
}

std::string DescribeLens(const LensModel& model) {
  return std::visit([](const auto& lens) { return TextOf(lens); }, model);
}

std::optional<Eigen::Vector2d> SeenAt(const LensModel& model, const Eigen::Vector3d& direction) {
  return std::visit([&](const auto& lens) { return Through(lens, direction); }, model);
}

std::optional<Eigen::Vector3d> DirectionOf(const LensModel& model, const Eigen::Vector2d& seen) {
  return std::visit([&](const auto& lens) { return Behind(lens, seen); }, model);
}

std::optional<Eigen::Vector2d> ProjectRaw(const RawCamera& camera,
                                          const Eigen::Vector3d& direction) {
  const Seen seen = SeenAt(camera.lens, direction);
  if (!seen.has_value()) return std::nullopt;
  return Eigen::Vector2d(camera.fx_px * seen->x() + camera.cx_px,
                         camera.fy_px * seen->y() + camera.cy_px);
}

std::optional<Eigen::Vector3d> UnprojectRaw(const RawCamera& camera,
                                            const Eigen::Vector2d& raw_px) {
  return DirectionOf(camera.lens, {(raw_px.x() - camera.cx_px) / camera.fx_px,
                                   (raw_px.y() - camera.cy_px) / camera.fy_px});
}

std::optional<Eigen::Vector2d> UndistortPixel(const Camera& camera, const LensModel& lens,
                                              const Eigen::Vector2d& raw_px) {
  const Eigen::Vector2d seen((raw_px.x() - camera.cx_px) / camera.fx_px,
                             (raw_px.y() - camera.cy_px) / camera.fy_px);
  if (const auto* const pinhole = std::get_if<RadialTangential>(&lens)) {
    if (pinhole->IsZero()) return raw_px;
    const Eigen::Vector2d ideal = Undistort(*pinhole, seen);
    return Eigen::Vector2d(camera.fx_px * ideal.x() + camera.cx_px,
                           camera.fy_px * ideal.y() + camera.cy_px);
  }
  const Direction direction = DirectionOf(lens, seen);
  if (!direction.has_value() || direction->z() < kLeastPinholeZ) return std::nullopt;
  return Project(camera, *direction);
}

}  // namespace corbslam
