#include "slam/sensor/rgbd_sensor.h"

#include "absl/strings/str_cat.h"
#include "slam/sensor/corner_depth.h"
#include "slam/sensor/image_check.h"
#include "slam/util/status_macros.h"

namespace corbslam {

absl::StatusOr<std::unique_ptr<Sensor>> RgbdSensor::Make(const RgbdCalibration& calibration,
                                                         const SensorOptions& options) {
  RETURN_IF_ERROR(Validate(calibration.camera));
  RETURN_IF_ERROR(Validate(calibration.lens));
  if (!calibration.camera.IsMetric()) {
    return absl::InvalidArgumentError("camera.baseline_m is 0, must be > 0 for RGB-D");
  }
  if (!(calibration.depth_units_per_m > 0 && calibration.depth_units_per_m <= 1e6)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "depth_units_per_m is ", calibration.depth_units_per_m, ", must be in (0, 1e6]"));
  }
  std::unique_ptr<Sensor> sensor(new RgbdSensor(calibration, options));
  RETURN_IF_ERROR(sensor->SetMask(calibration.mask));
  return sensor;
}

absl::StatusOr<Features> RgbdSensor::Process(const SensorImages& images) {
  RETURN_IF_ERROR(CheckGreyImage("grey", images.grey, camera_));
  RETURN_IF_ERROR(CheckDepthImage(images.depth, camera_));
  return grey_.FindFeatures(images.grey,
                            [&](Keypoint& keypoint) { AddDepth(images.depth, keypoint); });
}

absl::StatusOr<cv::Mat> RgbdSensor::Picture(const SensorImages& images) {
  RETURN_IF_ERROR(CheckGreyImage("grey", images.grey, camera_));
  RETURN_IF_ERROR(CheckDepthImage(images.depth, camera_));
  return images.grey;
}

std::optional<Keypoint> RgbdSensor::FromPicture(const SensorImages& images,
                                                const Keypoint& in_picture) const {
  Keypoint keypoint = in_picture;
  keypoint.disparity_px = 0;
  AddDepth(images.depth, keypoint);
  return grey_.Undistorted(keypoint);
}

void RgbdSensor::AddDepth(const cv::Mat& depth, Keypoint& keypoint) const {
  const double depth_m = CornerDepth(depth, keypoint, depth_units_per_m_);
  if (depth_m > 0) keypoint.disparity_px = static_cast<float>(DisparityFromDepth(camera_, depth_m));
}

}  // namespace corbslam
