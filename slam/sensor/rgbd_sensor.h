// Makes features of a grey image with a depth image. Internal to slam/sensor: use MakeSensor.
#ifndef CORBSLAM_SLAM_SENSOR_RGBD_SENSOR_H_
#define CORBSLAM_SLAM_SENSOR_RGBD_SENSOR_H_

#include <memory>
#include <optional>

#include "slam/sensor/sensor.h"
#include "slam/sensor/thread_pair.h"

namespace corbslam {

class RgbdSensor : public Sensor {
 public:
  static absl::StatusOr<std::unique_ptr<Sensor>> Make(const RgbdCalibration& calibration,
                                                      const SensorOptions& options);

  const Camera& camera() const override { return calibration_.camera; }
  absl::StatusOr<Features> Process(const SensorImages& images) override;
  absl::StatusOr<cv::Mat> Picture(const SensorImages& images) override;
  std::optional<Eigen::Vector2d> InPicture(const Eigen::Vector2d& ideal_px) const override;
  std::optional<Keypoint> FromPicture(const SensorImages& images,
                                      const Keypoint& in_picture) const override;
  absl::Status SetMask(const PictureMask& mask) override;

 private:
  RgbdSensor(const RgbdCalibration& calibration, const SensorOptions& options)
      : calibration_(calibration), extractor_(options.orb), threads_(options.parallel) {}
  // Gives a keypoint of the recorded picture its depth and its undistorted place. One that no
  // undistorted picture shows gets a place that is no number.
  void Complete(const cv::Mat& depth, Keypoint& keypoint) const;

  RgbdCalibration calibration_;
  OrbExtractor extractor_;
  ImagePyramid pyramid_;
  ThreadPair threads_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_RGBD_SENSOR_H_
