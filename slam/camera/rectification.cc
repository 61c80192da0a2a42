#include "slam/camera/rectification.h"

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <variant>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/camera/close_depth.h"
#include "slam/camera/pair_geometry.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

constexpr double kUnitTolerance = 1e-3;
constexpr double kLeastField_deg = 20;
constexpr double kMostField_deg = 150;

Camera PinholeOf(const RawCamera& raw, const RawStereo& pair) {
  return {.fx_px = raw.fx_px,
          .fy_px = raw.fy_px,
          .cx_px = raw.cx_px,
          .cy_px = raw.cy_px,
          .width_px = pair.width_px,
          .height_px = pair.height_px};
}

absl::Status WithSide(absl::string_view side, const absl::Status& status) {
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(side, " ", status.message()));
}

cv::Matx33d IntrinsicsMatrix(const RawCamera& raw) {
  return {raw.fx_px, 0, raw.cx_px, 0, raw.fy_px, raw.cy_px, 0, 0, 1};
}

// Returns OpenCV's coefficients. It gives other maps, by rounding, for eight of which three are 0.
std::vector<double> Coefficients(const LensModel& lens) {
  const auto& d = std::get<RadialTangential>(lens);
  if (!d.IsRational()) return {d.k1, d.k2, d.p1, d.p2, d.k3};
  return {d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6};
}

bool IsPinhole(const RawCamera& camera) {
  return std::holds_alternative<RadialTangential>(camera.lens);
}

Eigen::Matrix3d ToEigen(const cv::Matx33d& matrix) {
  Eigen::Matrix3d result;
  cv::cv2eigen(matrix, result);
  return result;
}

}  // namespace

absl::Status Validate(const RawStereo& raw) {
  for (const auto& [side, camera] :
       {std::pair("left", &raw.left), std::pair("right", &raw.right)}) {
    RETURN_IF_ERROR(WithSide(side, Validate(PinholeOf(*camera, raw))));
    RETURN_IF_ERROR(WithSide(side, Validate(camera->lens)));
  }
  if (!(raw.widest_field_deg >= kLeastField_deg && raw.widest_field_deg <= kMostField_deg)) {
    return absl::InvalidArgumentError(absl::StrCat("widest_field_deg is ", raw.widest_field_deg,
                                                   ", must be in [", kLeastField_deg, ", ",
                                                   kMostField_deg, "]"));
  }
  const Rigid3d& motion = raw.right_from_left;
  const double norm = motion.rotation.norm();
  if (!(std::abs(norm - 1) < kUnitTolerance)) {
    return absl::InvalidArgumentError(
        absl::StrCat("right_from_left: quaternion of norm ", norm, ", must be 1"));
  }
  const double right_x = CameraCentre(motion).x();
  const double distance = motion.translation.norm();
  if (!(distance > 1e-4 && distance < 1e3) || right_x < 0.5 * distance) {
    return absl::InvalidArgumentError(absl::StrCat(
        "right_from_left: the right camera is ", distance, " m from the left one, ", right_x,
        " m of it along +x; must be 0.0001 to 1000 m away and mostly along +x",
        right_x < -0.5 * distance ? ": are left and right exchanged, or is the motion inverted?"
                                  : ""));
  }
  return absl::OkStatus();
}

absl::StatusOr<StereoRectifier> StereoRectifier::Make(const RawStereo& raw) {
  RETURN_IF_ERROR(Validate(raw));
  StereoRectifier rectifier;
  try {
    const bool are_pinholes = IsPinhole(raw.left) && IsPinhole(raw.right);
    RETURN_IF_ERROR(are_pinholes ? rectifier.MakeAsOpenCv(raw) : rectifier.MakeOfFisheyes(raw));
  } catch (const cv::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("stereo rectification: ", error.what()));
  }
  RETURN_IF_ERROR(Validate(rectifier.camera_));
  return rectifier;
}

absl::Status StereoRectifier::MakeAsOpenCv(const RawStereo& raw) {
  const cv::Size size(raw.width_px, raw.height_px);
  cv::Matx33d rotation;
  cv::eigen2cv(Eigen::Matrix3d(raw.right_from_left.rotation.toRotationMatrix()), rotation);
  cv::Vec3d translation;
  cv::eigen2cv(raw.right_from_left.translation, translation);
  cv::Matx33d left_rotation, right_rotation;
  cv::Matx34d left_projection, right_projection;
  cv::Matx44d disparity_to_depth;
  cv::stereoRectify(IntrinsicsMatrix(raw.left), Coefficients(raw.left.lens),
                    IntrinsicsMatrix(raw.right), Coefficients(raw.right.lens), size, rotation,
                    translation, left_rotation, right_rotation, left_projection, right_projection,
                    disparity_to_depth, cv::CALIB_ZERO_DISPARITY, /*alpha=*/0);
  cv::initUndistortRectifyMap(IntrinsicsMatrix(raw.left), Coefficients(raw.left.lens),
                              left_rotation, left_projection, size, CV_16SC2, left_.pixels,
                              left_.fractions);
  cv::initUndistortRectifyMap(IntrinsicsMatrix(raw.right), Coefficients(raw.right.lens),
                              right_rotation, right_projection, size, CV_16SC2, right_.pixels,
                              right_.fractions);
  const double baseline_m = -right_projection(0, 3) / right_projection(0, 0);
  camera_ = {.fx_px = left_projection(0, 0),
             .fy_px = left_projection(1, 1),
             .cx_px = left_projection(0, 2),
             .cy_px = left_projection(1, 2),
             .width_px = raw.width_px,
             .height_px = raw.height_px,
             .baseline_m = baseline_m,
             .close_depth_m = kCloseDepth_baselines * baseline_m};
  rectified_from_raw_left_.rotation = Eigen::Quaterniond(ToEigen(left_rotation)).normalized();
  return absl::OkStatus();
}

absl::Status StereoRectifier::MakeOfFisheyes(const RawStereo& raw) {
  const PairRotations rotations = RotationsOf(raw.right_from_left);
  ASSIGN_OR_RETURN(camera_, WidestPinhole(raw, rotations));
  camera_.close_depth_m = kCloseDepth_baselines * camera_.baseline_m;
  ASSIGN_OR_RETURN(const cv::Mat left,
                   SourcePixels(camera_, rotations.rectified_from_left, raw.left));
  ASSIGN_OR_RETURN(const cv::Mat right,
                   SourcePixels(camera_, rotations.rectified_from_right, raw.right));
  cv::convertMaps(left, cv::noArray(), left_.pixels, left_.fractions, CV_16SC2);
  cv::convertMaps(right, cv::noArray(), right_.pixels, right_.fractions, CV_16SC2);
  rectified_from_raw_left_.rotation = rotations.rectified_from_left;
  return absl::OkStatus();
}

absl::Status StereoRectifier::RectifyLeft(const cv::Mat& raw, cv::Mat& rectified) const {
  return Rectify(left_, raw, rectified);
}

absl::Status StereoRectifier::RectifyRight(const cv::Mat& raw, cv::Mat& rectified) const {
  return Rectify(right_, raw, rectified);
}

absl::Status StereoRectifier::Rectify(const Maps& maps, const cv::Mat& raw,
                                      cv::Mat& rectified) const {
  if (raw.type() != CV_8UC1 || raw.size() != maps.pixels.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("rectification needs a grey image of 8 bits and ", camera_.width_px, "x",
                     camera_.height_px, " pixels, given ", raw.cols, "x", raw.rows, " of ",
                     raw.channels(), " channels and OpenCV depth ", raw.depth()));
  }
  try {
    cv::remap(raw, rectified, maps.pixels, maps.fractions, cv::INTER_LINEAR);
  } catch (const cv::Exception& error) {
    return absl::InternalError(absl::StrCat("rectification: ", error.what()));
  }
  return absl::OkStatus();
}

}  // namespace corbslam
