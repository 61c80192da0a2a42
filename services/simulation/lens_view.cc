#include "services/simulation/lens_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "absl/strings/str_cat.h"
#include "services/simulation/parallel_rows.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

using Eigen::Vector3d;

constexpr size_t kSidesOfCube = 6;
constexpr int kMargin_px = 2;

// The rays of all pixels' middles and of one pixel more all round; zero where the lens sees none.
class RayGrid {
 public:
  RayGrid(const RawCamera& camera, int width, int height)
      : stride_(width + 2), rays_(static_cast<size_t>(stride_) * static_cast<size_t>(height + 2)) {
    for (int y = -1; y <= height; ++y) {
      for (int x = -1; x <= width; ++x) {
        const std::optional<Vector3d> ray = UnprojectRaw(camera, {x, y});
        At(x, y) = ray.value_or(Vector3d::Zero());
      }
    }
  }
  const Vector3d& At(int x, int y) const { return rays_[Index(x, y)]; }
  // Returns the ray `right` and `down` of a pixel's middle, at most half a pixel; that of the
  // middle where a neighbour has none.
  Vector3d Near(int x, int y, double right, double down) const {
    const Vector3d& here = At(x, y);
    const Vector3d& across = At(right < 0 ? x - 1 : x + 1, y);
    const Vector3d& below = At(x, down < 0 ? y - 1 : y + 1);
    if (across.isZero(0) || below.isZero(0)) return here;
    return here + std::abs(right) * (across - here) + std::abs(down) * (below - here);
  }

 private:
  size_t Index(int x, int y) const {
    return static_cast<size_t>(y + 1) * static_cast<size_t>(stride_) + static_cast<size_t>(x + 1);
  }
  Vector3d& At(int x, int y) { return rays_[Index(x, y)]; }

  int stride_;
  std::vector<Vector3d> rays_;
};

// Ahead, to the right, back, to the left, down and up.
std::array<Eigen::Quaterniond, kSidesOfCube> SidesOfCube() {
  const auto turned = [](double quarters, const Vector3d& axis) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * std::numbers::pi * quarters, axis));
  };
  const Vector3d y = Vector3d::UnitY();
  const Vector3d x = Vector3d::UnitX();
  return {turned(0, y), turned(1, y), turned(2, y), turned(-1, y), turned(-1, x), turned(1, x)};
}

size_t SideOf(const Vector3d& ray) {
  const Vector3d size = ray.cwiseAbs();
  if (size.z() >= size.x() && size.z() >= size.y()) return ray.z() > 0 ? 0 : 2;
  if (size.x() >= size.y()) return ray.x() > 0 ? 1 : 3;
  return ray.y() > 0 ? 4 : 5;
}

// What the lens sees of one side, as slopes x/z and y/z.
struct Extent {
  double left = std::numeric_limits<double>::infinity();
  double right = -left;
  double top = left;
  double bottom = -left;
  double focal_px = 0;  // Of the coarsest pinhole that is as fine as the lens.

  bool IsSeen() const { return right >= left; }
  void Include(const Vector3d& in_side) {
    const double x = in_side.x() / in_side.z();
    const double y = in_side.y() / in_side.z();
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
  }
};

bool IsNarrow(const Vector3d& ray) {
  return ray.z() > 0 &&
         std::max(std::abs(ray.x()), std::abs(ray.y())) <= LensView::kWidestSlope * ray.z();
}

Camera PinholeOf(const Extent& extent) {
  const double focal = LensView::kFineness * std::max(extent.focal_px, 1.0);
  Camera camera;
  camera.fx_px = focal;
  camera.fy_px = focal;
  camera.cx_px = kMargin_px - std::floor(focal * extent.left);
  camera.cy_px = kMargin_px - std::floor(focal * extent.top);
  camera.width_px = static_cast<int>(std::ceil(focal * extent.right + camera.cx_px)) + kMargin_px;
  camera.height_px = static_cast<int>(std::ceil(focal * extent.bottom + camera.cy_px)) + kMargin_px;
  return camera;
}

float Interpolate(const cv::Mat& light, float x, float y) {
  const int left = std::clamp(static_cast<int>(x), 0, light.cols - 2);
  const int top = std::clamp(static_cast<int>(y), 0, light.rows - 2);
  const float s = x - static_cast<float>(left);
  const float t = y - static_cast<float>(top);
  const float* above = light.ptr<float>(top) + left;
  const float* below = light.ptr<float>(top + 1) + left;
  return (1 - t) * ((1 - s) * above[0] + s * above[1]) + t * ((1 - s) * below[0] + s * below[1]);
}

using Extents = std::array<Extent, kSidesOfCube>;

// Measures what each side must show; `one` says that the first one shows it all.
Extents Measure(const RayGrid& rays, int width, int height, bool one) {
  const auto sides = SidesOfCube();
  Extents extents;
  for (int y = -1; y <= height; ++y) {
    for (int x = -1; x <= width; ++x) {
      const Vector3d& ray = rays.At(x, y);
      if (ray.isZero(0)) continue;
      const size_t side = one ? 0 : SideOf(ray);
      const Vector3d in_side = sides[side].conjugate() * ray;
      extents[side].Include(in_side);
      if (x == width || rays.At(x + 1, y).isZero(0)) continue;
      // A pinhole is finer away from its axis: radially by the cosine's inverse square.
      const double pixel_rad = (rays.At(x + 1, y) - ray).norm();
      const double cosine = in_side.z() / in_side.norm();
      extents[side].focal_px = std::max(extents[side].focal_px, cosine * cosine / pixel_rad);
    }
  }
  return extents;
}

bool AllNarrow(const RayGrid& rays, int width, int height) {
  for (int y = -1; y <= height; ++y) {
    for (int x = -1; x <= width; ++x) {
      if (!rays.At(x, y).isZero(0) && !IsNarrow(rays.At(x, y))) return false;
    }
  }
  return true;
}

}  // namespace

absl::StatusOr<LensView> LensView::Make(const RawCamera& camera, int width_px, int height_px) {
  RETURN_IF_ERROR(Validate(camera.lens));
  if (!(camera.fx_px > 0 && camera.fy_px > 0 && width_px > 0 && height_px > 0)) {
    return absl::InvalidArgumentError(
        absl::StrCat("a camera of ", width_px, "x", height_px, " pixels with focal lengths of ",
                     camera.fx_px, " and ", camera.fy_px, " px: all must be above 0"));
  }
  const RayGrid rays(camera, width_px, height_px);
  const bool one = AllNarrow(rays, width_px, height_px);
  const Extents extents = Measure(rays, width_px, height_px, one);
  const auto turns = SidesOfCube();
  LensView view;
  view.width_px_ = width_px;
  view.height_px_ = height_px;
  std::array<int, kSidesOfCube> number;
  number.fill(kNoSide);
  for (size_t i = 0; i < kSidesOfCube; ++i) {
    if (!extents[i].IsSeen()) continue;
    number[i] = static_cast<int>(view.sides_.size());
    view.sides_.push_back({turns[i], PinholeOf(extents[i])});
  }
  if (view.sides_.empty()) return absl::InvalidArgumentError("the lens sees nothing");
  view.taps_.resize(static_cast<size_t>(width_px) * static_cast<size_t>(height_px) * kTaps);
  Tap* tap = view.taps_.data();
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x) {
      for (int i = 0; i < kTaps; ++i, ++tap) {
        if (rays.At(x, y).isZero(0)) continue;
        const Vector3d ray = rays.Near(x, y, i % 2 == 0 ? -0.25 : 0.25, i < 2 ? -0.25 : 0.25);
        const size_t side = one ? 0 : SideOf(ray);
        if (number[side] == kNoSide) continue;
        const Side& drawn = view.sides_[static_cast<size_t>(number[side])];
        const Eigen::Vector2d at = Project(drawn.pinhole, drawn.camera_from_side.conjugate() * ray);
        *tap = {static_cast<float>(at.x()), static_cast<float>(at.y()), number[side]};
      }
    }
  }
  return view;
}

cv::Mat LensView::Resample(const std::vector<cv::Mat>& light, int threads) const {
  cv::Mat seen(height_px_, width_px_, CV_32FC1);
  ParallelRows(threads, height_px_, [&](int y) {
    const Tap* tap = taps_.data() + static_cast<size_t>(y) * static_cast<size_t>(width_px_) * kTaps;
    float* to = seen.ptr<float>(y);
    for (int x = 0; x < width_px_; ++x) {
      float sum = 0;
      for (int i = 0; i < kTaps; ++i, ++tap) {
        if (tap->side == kNoSide) continue;
        sum += Interpolate(light[static_cast<size_t>(tap->side)], tap->x, tap->y);
      }
      to[x] = sum / kTaps;
    }
  });
  return seen;
}

}  // namespace corbslam
