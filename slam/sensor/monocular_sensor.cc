#include "slam/sensor/monocular_sensor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/sensor/image_check.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

const Eigen::Vector2d kNowhere =
    Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());

// Takes out features that have no place in the undistorted picture (a fisheye's edge).
void TakeOutUnseen(Features& features) {
  size_t kept = 0;
  for (size_t i = 0; i < features.keypoints.size(); ++i) {
    if (std::isnan(features.keypoints[i].x_px)) continue;
    features.keypoints[kept] = features.keypoints[i];
    features.descriptors[kept++] = features.descriptors[i];
  }
  features.keypoints.resize(kept);
  features.descriptors.resize(kept);
}

// A place that no undistorted picture shows becomes one that is no number.
void Undistort(const Camera& camera, const LensModel& lens, Keypoint& keypoint) {
  const Eigen::Vector2d ideal = UndistortPixel(camera, lens, keypoint.Pixel()).value_or(kNowhere);
  keypoint.x_px = static_cast<float>(ideal.x());
  keypoint.y_px = static_cast<float>(ideal.y());
}

}  // namespace

absl::StatusOr<std::unique_ptr<Sensor>> MonocularSensor::Make(
    const MonocularCalibration& calibration, const SensorOptions& options) {
  RETURN_IF_ERROR(Validate(calibration.camera));
  RETURN_IF_ERROR(Validate(calibration.lens));
  if (calibration.camera.IsMetric()) {
    return absl::InvalidArgumentError(absl::StrCat("camera.baseline_m is ",
                                                   calibration.camera.baseline_m,
                                                   ", must be 0 for one camera alone"));
  }
  auto sensor = std::make_unique<MonocularSensor>(calibration, options);
  RETURN_IF_ERROR(sensor->SetMask(calibration.mask));
  return sensor;
}

absl::Status MonocularSensor::SetMask(const PictureMask& mask) {
  RETURN_IF_ERROR(CheckMask(mask, calibration_.camera));
  calibration_.mask = mask;
  extractor_.SetMask(mask);
  return absl::OkStatus();
}

absl::StatusOr<Features> MonocularSensor::FindFeatures(const cv::Mat& grey, Measure measure) {
  RETURN_IF_ERROR(CheckGreyImage("grey", grey, calibration_.camera));
  RETURN_IF_ERROR(extractor_.Begin(grey, pyramid_));
  threads_.Run(ScalePyramid::kLevels, [this](size_t octave) {
    extractor_.ExtractLevel(pyramid_, static_cast<int>(octave));
  });
  Features features;
  RETURN_IF_ERROR(extractor_.Gather(features));
  constexpr size_t kTask = 100;  // Number of keypoints.
  std::vector<Keypoint>& keypoints = features.keypoints;
  threads_.Run((keypoints.size() + kTask - 1) / kTask, [&](size_t task) {
    const size_t end = std::min((task + 1) * kTask, keypoints.size());
    for (size_t i = task * kTask; i < end; ++i) {
      measure(keypoints[i]);
      Undistort(calibration_.camera, calibration_.lens, keypoints[i]);
    }
  });
  TakeOutUnseen(features);
  return features;
}

absl::StatusOr<Features> MonocularSensor::Process(const SensorImages& images) {
  return FindFeatures(images.grey, [](Keypoint&) {});
}

absl::StatusOr<cv::Mat> MonocularSensor::Picture(const SensorImages& images) {
  RETURN_IF_ERROR(CheckGreyImage("grey", images.grey, calibration_.camera));
  return images.grey;
}

std::optional<Eigen::Vector2d> MonocularSensor::InPicture(const Eigen::Vector2d& ideal_px) const {
  const Camera& camera = calibration_.camera;
  const std::optional<Eigen::Vector2d> seen =
      SeenAt(calibration_.lens, Unproject(camera, ideal_px.x(), ideal_px.y(), 1));
  if (!seen.has_value()) return std::nullopt;
  const Eigen::Vector2d pixel(camera.fx_px * seen->x() + camera.cx_px,
                              camera.fy_px * seen->y() + camera.cy_px);
  if (!IsInImage(camera, pixel) || IsMasked(calibration_.mask, pixel)) return std::nullopt;
  return pixel;
}

std::optional<Keypoint> MonocularSensor::FromPicture(const SensorImages& /*images*/,
                                                     const Keypoint& in_picture) const {
  Keypoint keypoint = in_picture;
  keypoint.disparity_px = 0;
  return Undistorted(keypoint);
}

std::optional<Keypoint> MonocularSensor::Undistorted(const Keypoint& in_picture) const {
  Keypoint keypoint = in_picture;
  Undistort(calibration_.camera, calibration_.lens, keypoint);
  if (std::isnan(keypoint.x_px)) return std::nullopt;
  return keypoint;
}

}  // namespace corbslam
