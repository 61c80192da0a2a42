// Makes features of a grey image with a depth image. Internal to slam/sensor: use MakeSensor.
#ifndef CORBSLAM_SLAM_SENSOR_RGBD_SENSOR_H_
#define CORBSLAM_SLAM_SENSOR_RGBD_SENSOR_H_

#include <memory>
#include <optional>

#include "slam/sensor/monocular_sensor.h"
#include "slam/sensor/sensor.h"

namespace corbslam {

class RgbdSensor : public Sensor {
 public:
  static absl::StatusOr<std::unique_ptr<Sensor>> Make(const RgbdCalibration& calibration,
                                                      const SensorOptions& options);

  const Camera& camera() const override { return camera_; }
  absl::StatusOr<Features> Process(const SensorImages& images) override;
  absl::StatusOr<cv::Mat> Picture(const SensorImages& images) override;
  std::optional<Eigen::Vector2d> InPicture(const Eigen::Vector2d& ideal_px) const override {
    return grey_.InPicture(ideal_px);
  }
  std::optional<Keypoint> FromPicture(const SensorImages& images,
                                      const Keypoint& in_picture) const override;
  absl::Status SetMask(const PictureMask& mask) override { return grey_.SetMask(mask); }

 private:
  RgbdSensor(const RgbdCalibration& calibration, const SensorOptions& options)
      : camera_(calibration.camera),
        depth_units_per_m_(calibration.depth_units_per_m),
        grey_(FirstCameraOf(calibration), options) {}
  // Gives a keypoint of the recorded picture its depth.
  void AddDepth(const cv::Mat& depth, Keypoint& keypoint) const;

  const Camera camera_;
  const double depth_units_per_m_;
  MonocularSensor grey_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_RGBD_SENSOR_H_
