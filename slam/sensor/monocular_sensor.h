// Makes features of a grey image alone. Internal to slam/sensor: use MakeSensor.
#ifndef CORBSLAM_SLAM_SENSOR_MONOCULAR_SENSOR_H_
#define CORBSLAM_SLAM_SENSOR_MONOCULAR_SENSOR_H_

#include <memory>
#include <optional>

#include "absl/functional/function_ref.h"
#include "slam/sensor/sensor.h"
#include "slam/sensor/thread_pair.h"

namespace corbslam {

class MonocularSensor : public Sensor {
 public:
  static absl::StatusOr<std::unique_ptr<Sensor>> Make(const MonocularCalibration& calibration,
                                                      const SensorOptions& options);
  // The calibration must be possible, and without a mask.
  MonocularSensor(const MonocularCalibration& calibration, const SensorOptions& options)
      : calibration_(calibration), extractor_(options.orb), threads_(options.parallel) {}

  const Camera& camera() const override { return calibration_.camera; }
  absl::StatusOr<Features> Process(const SensorImages& images) override;
  absl::StatusOr<cv::Mat> Picture(const SensorImages& images) override;
  std::optional<Eigen::Vector2d> InPicture(const Eigen::Vector2d& ideal_px) const override;
  std::optional<Keypoint> FromPicture(const SensorImages& images,
                                      const Keypoint& in_picture) const override;
  absl::Status SetMask(const PictureMask& mask) override;

  // Changes a keypoint of the recorded picture; called from two threads.
  using Measure = absl::FunctionRef<void(Keypoint&)>;

  // Finds features of a grey picture, has each one measured where it was found, and moves it to its
  // undistorted place; those that have none are left out. Errors as those of Process.
  absl::StatusOr<Features> FindFeatures(const cv::Mat& grey, Measure measure);
  // Returns the keypoint at its undistorted place; nullopt where it has none.
  std::optional<Keypoint> Undistorted(const Keypoint& in_picture) const;

 private:
  MonocularCalibration calibration_;
  OrbExtractor extractor_;
  ImagePyramid pyramid_;
  ThreadPair threads_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_MONOCULAR_SENSOR_H_
