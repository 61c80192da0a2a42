// Makes of what a camera saw at a keyframe a small picture for people.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_PICTURE_ENCODER_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_PICTURE_ENCODER_H_

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "slam/camera/rectification.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// Thread-compatible.
class PictureEncoder {
 public:
  struct Encoded {
    std::string jpeg;
    double scale = 1;  // KeyframePicture::scale.
  };

  // Pictures of any form have about as many pixels as one that is `width_px` wide and three
  // quarters as high, and no more than the camera's. INVALID_ARGUMENT for an impossible
  // calibration. Takes tens of milliseconds where a lens distorts.
  static absl::StatusOr<PictureEncoder> Make(const SensorCalibration& calibration, int width_px);

  // `grey` is the recorded (left) picture, CV_8UC1 of the calibration's size. Undistorts it as the
  // keypoints are, scales it down and encodes it, in at most kMaxPictureBytes. INTERNAL: OpenCV
  // could not.
  absl::StatusOr<Encoded> Encode(const cv::Mat& grey) const;

 private:
  explicit PictureEncoder(int width_px) : width_px_(width_px) {}
  absl::StatusOr<cv::Mat> Undistort(const cv::Mat& grey) const;

  int width_px_;
  std::optional<StereoRectifier> rectifier_;  // Of a raw stereo pair.
  cv::Mat undistortion_;  // Of an RGB-D camera's lens: for each pixel its place as recorded.
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_PICTURE_ENCODER_H_
