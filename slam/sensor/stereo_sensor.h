// Makes features of a stereo pair. Internal to slam/sensor: use MakeSensor.
#ifndef CORBSLAM_SLAM_SENSOR_STEREO_SENSOR_H_
#define CORBSLAM_SLAM_SENSOR_STEREO_SENSOR_H_

#include <memory>
#include <optional>

#include "slam/sensor/row_offset.h"
#include "slam/sensor/sensor.h"
#include "slam/sensor/thread_pair.h"

namespace corbslam {

class StereoSensor : public Sensor {
 public:
  static absl::StatusOr<std::unique_ptr<Sensor>> Make(const StereoCalibration& calibration,
                                                      const SensorOptions& options);

  const Camera& camera() const override { return camera_; }
  absl::StatusOr<Features> Process(const SensorImages& images) override;
  absl::StatusOr<cv::Mat> Picture(const SensorImages& images) override;
  std::optional<Eigen::Vector2d> InPicture(const Eigen::Vector2d& ideal_px) const override;
  std::optional<Keypoint> FromPicture(const SensorImages& images,
                                      const Keypoint& in_picture) const override;
  absl::Status SetMask(const PictureMask& mask) override;
  double row_correction_px() const override { return rows_.correction_px(); }

 private:
  // One camera's part of the work and its buffers.
  struct Side {
    explicit Side(const OrbOptions& options) : extractor(options) {}
    OrbExtractor extractor;
    cv::Mat rectified;
    Features features;
    ImagePyramid pyramid;
    absl::Status status;
  };

  StereoSensor(const Camera& camera, std::optional<StereoRectifier> rectifier,
               double right_cx_offset_px, const SensorOptions& options);
  absl::Status BeginLeft(const cv::Mat& image);
  absl::Status BeginRight(const cv::Mat& image);
  absl::StatusOr<cv::Mat> Rectified(const cv::Mat& right);

  Camera camera_;
  cv::Mat mask_;  // Of the rectified left picture; empty: none.
  std::optional<StereoRectifier> rectifier_;
  // StereoCalibration::right_cx_offset_px in whole columns, by which the right image is moved, and
  // what is left of it.
  int right_columns_ = 0;
  double right_rest_px_ = 0;
  RowOffset rows_;
  Side left_;
  Side right_;
  ThreadPair threads_;
  cv::Mat picture_;  // What Picture made of a raw one.
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_STEREO_SENSOR_H_
