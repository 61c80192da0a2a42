#include "slam/camera/depth_registration.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

constexpr double kMostApart_m = 1;
// Neighbours on a slope come apart by less than this, so that no line of holes is between them.
constexpr float kMargin_px = 0.1F;
// A pixel that covers more lies beside the colour camera's eye and tells nothing.
constexpr float kMostReach_px = 16;
constexpr float kLeastZ_m = 0.01F;
constexpr double kFarthestRadius = 6;  // Of a pinhole's picture, in focal lengths: 80 degrees.
constexpr double kRadiusStep = 0.005;
constexpr double kUnitTolerance = 1e-3;

absl::Status CheckCamera(absl::string_view which, const RawCamera& camera, const cv::Size& size) {
  const absl::Status status = Validate(Camera{.fx_px = camera.fx_px,
                                              .fy_px = camera.fy_px,
                                              .cx_px = camera.cx_px,
                                              .cy_px = camera.cy_px,
                                              .width_px = size.width,
                                              .height_px = size.height});
  const absl::Status lens = Validate(camera.lens);
  if (status.ok() && lens.ok()) return status;
  const absl::Status& bad = status.ok() ? lens : status;
  return absl::Status(bad.code(), absl::StrCat(which, " ", bad.message()));
}

// Returns the squared radius at which a lens stops growing, at most kFarthestRadius squared.
double FoldOf(const RadialTangential& lens) {
  double before = 0;
  for (double r = kRadiusStep; r < kFarthestRadius; r += kRadiusStep) {
    const double seen = r * RadialFactor(lens, r * r);
    if (!(seen > before)) return (r - kRadiusStep) * (r - kRadiusStep);
    before = seen;
  }
  return kFarthestRadius * kFarthestRadius;
}

template <typename Depth>
constexpr bool kIsInteger = std::is_integral_v<Depth>;

template <typename Depth>
float ToMetres(Depth value, float units_per_m) {
  if constexpr (kIsInteger<Depth>) {
    return value == std::numeric_limits<Depth>::max() ? 0 : static_cast<float>(value) / units_per_m;
  } else {
    return std::isfinite(value) ? value : 0;
  }
}

// Returns 0 for what the type can't hold.
template <typename Depth>
Depth FromMetres(float z_m, float units_per_m) {
  if constexpr (kIsInteger<Depth>) {
    const float units = std::round(z_m * units_per_m);
    return units < std::numeric_limits<Depth>::max() ? static_cast<Depth>(units) : Depth{0};
  } else {
    return z_m;
  }
}

// Puts `value` wherever it is the nearest.
template <typename Depth>
void Splat(const Eigen::Vector2f& at_px, const Eigen::Vector2f& reach_px, Depth value,
           cv::Mat& registered) {
  const Eigen::Vector2f low = at_px - reach_px;
  const Eigen::Vector2f high = at_px + reach_px;
  const int left = std::max(0, static_cast<int>(std::ceil(low.x())));
  const int right = std::min(registered.cols - 1, static_cast<int>(std::floor(high.x())));
  const int top = std::max(0, static_cast<int>(std::ceil(low.y())));
  const int bottom = std::min(registered.rows - 1, static_cast<int>(std::floor(high.y())));
  for (int y = top; y <= bottom; ++y) {
    auto* const row = registered.ptr<Depth>(y);
    for (int x = left; x <= right; ++x) {
      if (row[x] == 0 || value < row[x]) row[x] = value;
    }
  }
}

}  // namespace

absl::Status Validate(const DepthGeometry& geometry) {
  RETURN_IF_ERROR(CheckCamera("depth", geometry.depth, geometry.depth_px));
  RETURN_IF_ERROR(CheckCamera("colour", geometry.colour, geometry.colour_px));
  const Rigid3d& motion = geometry.colour_from_depth;
  if (!(std::abs(motion.rotation.norm() - 1) < kUnitTolerance)) {
    return absl::InvalidArgumentError(absl::StrCat("colour_from_depth: quaternion of norm ",
                                                   motion.rotation.norm(), ", must be 1"));
  }
  const double apart_m = motion.translation.norm();
  if (apart_m <= kMostApart_m) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("colour_from_depth: the cameras are ", apart_m,
                                                 " m apart, must be at most ", kMostApart_m,
                                                 ": is it in metres?"));
}

DepthRegistration::DepthRegistration(const DepthGeometry& geometry)
    : geometry_(geometry), translation_(geometry.colour_from_depth.translation.cast<float>()) {
  if (const auto* const lens = std::get_if<RadialTangential>(&geometry.colour.lens)) {
    most_r2_ = static_cast<float>(FoldOf(*lens));
  }
  MakeRays();
}

absl::StatusOr<DepthRegistration> DepthRegistration::Make(const DepthGeometry& geometry) {
  RETURN_IF_ERROR(Validate(geometry));
  return DepthRegistration(geometry);
}

void DepthRegistration::MakeRays() {
  rays_.reserve(static_cast<size_t>(geometry_.depth_px.area()));
  for (int y = 0; y < geometry_.depth_px.height; ++y) {
    for (int x = 0; x < geometry_.depth_px.width; ++x) rays_.push_back(RayOf(x, y));
  }
}

DepthRegistration::Ray DepthRegistration::RayOf(int x, int y) const {
  Ray ray{Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()), {0, 0}};
  const Eigen::Quaterniond& rotation = geometry_.colour_from_depth.rotation;
  const auto look = [&](double px, double py) -> std::optional<Eigen::Vector3d> {
    const auto direction = UnprojectRaw(geometry_.depth, {px, py});
    if (!direction.has_value() || !(direction->z() > kLeastZ_m)) return std::nullopt;
    return rotation * (*direction / direction->z());
  };
  const std::optional<Eigen::Vector3d> middle = look(x, y);
  if (!middle.has_value()) return ray;
  // What it covers far away, in the colour picture; where that isn't known, by the focal lengths.
  Eigen::Vector2f reach(static_cast<float>(0.5 * geometry_.colour.fx_px / geometry_.depth.fx_px),
                        static_cast<float>(0.5 * geometry_.colour.fy_px / geometry_.depth.fy_px));
  Eigen::AlignedBox2f covered;
  int seen = 0;
  for (const auto& [dx, dy] : {std::pair(-0.5, -0.5), {0.5, -0.5}, {-0.5, 0.5}, {0.5, 0.5}}) {
    const std::optional<Eigen::Vector3d> corner = look(x + dx, y + dy);
    Eigen::Vector2f at_px;
    if (!corner.has_value() || !Project(corner->cast<float>(), at_px)) continue;
    covered.extend(at_px);
    ++seen;
  }
  if (seen == 4) reach = 0.5F * covered.sizes();
  ray.per_metre = middle->cast<float>();
  ray.reach_px = reach * ray.per_metre.z();
  return ray;
}

bool DepthRegistration::Project(const Eigen::Vector3f& point, Eigen::Vector2f& at_px) const {
  const RawCamera& camera = geometry_.colour;
  const auto* const lens = std::get_if<RadialTangential>(&camera.lens);
  Eigen::Vector2d seen;
  if (lens != nullptr) {
    if (!(point.z() > kLeastZ_m)) return false;
    const Eigen::Vector2f ideal = point.head<2>() / point.z();
    if (!(ideal.squaredNorm() <= most_r2_)) return false;
    seen = Distort(*lens, ideal.cast<double>());
  } else {
    const std::optional<Eigen::Vector2d> through = SeenAt(camera.lens, point.cast<double>());
    if (!through.has_value()) return false;
    seen = *through;
  }
  at_px = {static_cast<float>(camera.fx_px * seen.x() + camera.cx_px),
           static_cast<float>(camera.fy_px * seen.y() + camera.cy_px)};
  return true;
}

template <typename Depth>
cv::Mat DepthRegistration::RegisterAs(const cv::Mat& depth, float units_per_m) const {
  cv::Mat registered = cv::Mat::zeros(geometry_.colour_px, depth.type());
  const Ray* ray = rays_.data();
  for (int y = 0; y < depth.rows; ++y) {
    const auto* const row = depth.ptr<Depth>(y);
    for (int x = 0; x < depth.cols; ++x, ++ray) {
      const float depth_m = ToMetres(row[x], units_per_m);
      if (!(depth_m > 0)) continue;
      const Eigen::Vector3f point = depth_m * ray->per_metre + translation_;
      Eigen::Vector2f at_px;
      if (!(point.z() > kLeastZ_m) || !Project(point, at_px)) continue;
      const Eigen::Vector2f reach_px = ray->reach_px * (depth_m / point.z());
      if (!(reach_px.maxCoeff() <= kMostReach_px)) continue;
      const auto value = FromMetres<Depth>(point.z(), units_per_m);
      if (value > 0) Splat(at_px, (reach_px.array() + kMargin_px).matrix(), value, registered);
    }
  }
  return registered;
}

absl::StatusOr<cv::Mat> DepthRegistration::Register(const cv::Mat& depth,
                                                    double units_per_m) const {
  if (depth.size() != geometry_.depth_px ||
      (depth.type() != CV_16UC1 && depth.type() != CV_32FC1)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a depth picture of ", depth.cols, "x", depth.rows, " ", cv::typeToString(depth.type()),
        ", its camera's are of ", geometry_.depth_px.width, "x", geometry_.depth_px.height,
        " CV_16UC1 or CV_32FC1"));
  }
  if (depth.type() == CV_32FC1) return RegisterAs<float>(depth, 1);
  return RegisterAs<uint16_t>(depth, static_cast<float>(units_per_m));
}

}  // namespace corbslam
