#include "slam/sensor/rgbd_sensor.h"

#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "slam/sensor/corner_depth.h"
#include "slam/sensor/image_check.h"
#include "slam/util/status_macros.h"

namespace corbslam {

absl::StatusOr<std::unique_ptr<Sensor>> RgbdSensor::Make(const RgbdCalibration& calibration,
                                                         const SensorOptions& options) {
  RETURN_IF_ERROR(Validate(calibration.camera));
  RETURN_IF_ERROR(Validate(calibration.distortion));
  if (!calibration.camera.IsMetric()) {
    return absl::InvalidArgumentError("camera.baseline_m is 0, must be > 0 for RGB-D");
  }
  if (!(calibration.depth_units_per_m > 0 && calibration.depth_units_per_m <= 1e6)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "depth_units_per_m is ", calibration.depth_units_per_m, ", must be in (0, 1e6]"));
  }
  return std::unique_ptr<Sensor>(new RgbdSensor(calibration, options));
}

absl::StatusOr<Features> RgbdSensor::Process(const SensorImages& images) {
  const Camera& camera = calibration_.camera;
  RETURN_IF_ERROR(CheckGreyImage("grey", images.grey, camera));
  RETURN_IF_ERROR(CheckDepthImage(images.depth, camera));
  RETURN_IF_ERROR(extractor_.Begin(images.grey, pyramid_));
  threads_.Run(ScalePyramid::kLevels, [this](size_t octave) {
    extractor_.ExtractLevel(pyramid_, static_cast<int>(octave));
  });
  Features features;
  RETURN_IF_ERROR(extractor_.Gather(features));
  constexpr size_t kTask = 100;  // Number of keypoints.
  std::vector<Keypoint>& keypoints = features.keypoints;
  threads_.Run((keypoints.size() + kTask - 1) / kTask, [&](size_t task) {
    const size_t end = std::min((task + 1) * kTask, keypoints.size());
    for (size_t i = task * kTask; i < end; ++i) Complete(images.depth, keypoints[i]);
  });
  return features;
}

void RgbdSensor::Complete(const cv::Mat& depth, Keypoint& keypoint) const {
  const Camera& camera = calibration_.camera;
  const double depth_m = CornerDepth(depth, keypoint, calibration_.depth_units_per_m);
  if (depth_m > 0) keypoint.disparity_px = static_cast<float>(DisparityFromDepth(camera, depth_m));
  const Eigen::Vector2d ideal = UndistortPixel(camera, calibration_.distortion, keypoint.Pixel());
  keypoint.x_px = static_cast<float>(ideal.x());
  keypoint.y_px = static_cast<float>(ideal.y());
}

}  // namespace corbslam
