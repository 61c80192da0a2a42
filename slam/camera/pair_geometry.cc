#include "slam/camera/pair_geometry.h"

#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <optional>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

constexpr double kNarrowField_deg = 20;
constexpr int kSearchSteps = 30;
constexpr int kSamplesPerSide = 64;

// Where a ray of the rectified camera falls in a raw picture, if it does.
struct Side {
  const RawCamera& raw;
  Eigen::Quaterniond raw_from_rectified;
};

bool IsInPicture(const Eigen::Vector2d& pixel, const RawStereo& pair) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= pair.width_px - 1 &&
         pixel.y() <= pair.height_px - 1;
}

Camera PinholeOfField(const RawStereo& pair, double field_deg) {
  const double half_rad = field_deg * std::numbers::pi / 360;
  Camera camera;
  camera.width_px = pair.width_px;
  camera.height_px = pair.height_px;
  camera.cx_px = 0.5 * (pair.width_px - 1);
  camera.cy_px = 0.5 * (pair.height_px - 1);
  camera.fx_px = camera.fy_px = 0.5 * pair.width_px / std::tan(half_rad);
  camera.baseline_m = pair.right_from_left.translation.norm();
  return camera;
}

bool Shows(const Side& side, const RawStereo& pair, const Camera& camera, double x_px,
           double y_px) {
  const Eigen::Vector3d ray = side.raw_from_rectified * Unproject(camera, x_px, y_px, 1);
  const std::optional<Eigen::Vector2d> pixel = ProjectRaw(side.raw, ray);
  return pixel.has_value() && IsInPicture(*pixel, pair);
}

// Returns true if the edge of the rectified picture lies within the raw one. What is seen of a lens
// has no holes, so that all within the edge does.
bool ShowsEdge(const Side& side, const RawStereo& pair, const Camera& camera) {
  for (int i = 0; i <= kSamplesPerSide; ++i) {
    const double x_px = (camera.width_px - 1.0) * i / kSamplesPerSide;
    const double y_px = (camera.height_px - 1.0) * i / kSamplesPerSide;
    if (!Shows(side, pair, camera, x_px, 0) || !Shows(side, pair, camera, 0, y_px) ||
        !Shows(side, pair, camera, x_px, camera.height_px - 1.0) ||
        !Shows(side, pair, camera, camera.width_px - 1.0, y_px)) {
      return false;
    }
  }
  return true;
}

}  // namespace

PairRotations RotationsOf(const Rigid3d& right_from_left) {
  const Eigen::Quaterniond half =
      Eigen::Quaterniond::Identity().slerp(0.5, right_from_left.rotation);
  // The right camera's centre as the half-way orientation sees it.
  const Eigen::Vector3d towards_right = -(half.conjugate() * right_from_left.translation);
  const auto along_x = Eigen::Quaterniond::FromTwoVectors(towards_right, Eigen::Vector3d::UnitX());
  return {(along_x * half).normalized(), (along_x * half.conjugate()).normalized()};
}

absl::StatusOr<Camera> WidestPinhole(const RawStereo& raw, const PairRotations& rotations) {
  const Side left = {raw.left, rotations.rectified_from_left.conjugate()};
  const Side right = {raw.right, rotations.rectified_from_right.conjugate()};
  const auto fits = [&](double field_deg) {
    const Camera camera = PinholeOfField(raw, field_deg);
    return ShowsEdge(left, raw, camera) && ShowsEdge(right, raw, camera);
  };
  if (fits(raw.widest_field_deg)) return PinholeOfField(raw, raw.widest_field_deg);
  double narrow_deg = kNarrowField_deg;
  double wide_deg = raw.widest_field_deg;
  if (!fits(narrow_deg)) {
    return absl::InvalidArgumentError(
        absl::StrCat("rectification: the pair's pictures have not even ", kNarrowField_deg,
                     " degrees in common around the axis: do the cameras look in different "
                     "directions, or are the intrinsics of pictures of another size?"));
  }
  for (int i = 0; i < kSearchSteps; ++i) {
    const double middle_deg = 0.5 * (narrow_deg + wide_deg);
    (fits(middle_deg) ? narrow_deg : wide_deg) = middle_deg;
  }
  return PinholeOfField(raw, narrow_deg);
}

absl::StatusOr<cv::Mat> SourcePixels(const Camera& camera,
                                     const Eigen::Quaterniond& rectified_from_raw,
                                     const RawCamera& raw) {
  const Eigen::Quaterniond raw_from_rectified = rectified_from_raw.conjugate();
  cv::Mat pixels(camera.height_px, camera.width_px, CV_32FC2);
  for (int y = 0; y < pixels.rows; ++y) {
    for (int x = 0; x < pixels.cols; ++x) {
      const std::optional<Eigen::Vector2d> pixel =
          ProjectRaw(raw, raw_from_rectified * Unproject(camera, x, y, 1));
      if (!pixel.has_value()) {
        return absl::InvalidArgumentError(absl::StrCat("rectification: the lens does not see ", x,
                                                       ", ", y, " of the rectified picture"));
      }
      pixels.at<cv::Vec2f>(y, x) = {static_cast<float>(pixel->x()), static_cast<float>(pixel->y())};
    }
  }
  return pixels;
}

}  // namespace corbslam
