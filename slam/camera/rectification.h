// Rectification of a raw stereo pair: both images are resampled so that a point of the world has
// the same row in both, without distortion.
#ifndef CORBSLAM_SLAM_CAMERA_RECTIFICATION_H_
#define CORBSLAM_SLAM_CAMERA_RECTIFICATION_H_

#include <opencv2/core/mat.hpp>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/camera/camera.h"
#include "slam/camera/lens.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// A stereo pair as it is calibrated: images of the same size, not rectified.
struct RawStereo {
  RawCamera left;
  RawCamera right;
  // Translation in metres; the right camera must lie on the left one's +x side.
  Rigid3d right_from_left;
  int width_px = 0;
  int height_px = 0;
  // How wide the rectified pictures of fisheyes may be from left to right, 20 to 150 degrees. A
  // pinhole's edges are stretched: at 110 degrees three times as far as its middle.
  double widest_field_deg = 110;
};

// INVALID_ARGUMENT names the field and its value where a calibration is impossible.
absl::Status Validate(const RawStereo& raw);

// Immutable after it is made; RectifyLeft and RectifyRight may run at the same time.
class StereoRectifier {
 public:
  // The rectified images have the size of the raw ones and no pixels from outside them. Pairs of
  // radial-tangential lenses are rectified as OpenCV's stereoRectify does with alpha 0 (Bouguet's
  // method); others likewise, to the widest pinhole that shows no more than widest_field_deg.
  // INVALID_ARGUMENT for an impossible calibration.
  static absl::StatusOr<StereoRectifier> Make(const RawStereo& raw);

  // The camera of the rectified pair: baseline_m is set, close_depth_m is 40 baselines.
  const Camera& camera() const { return camera_; }
  // Orientation of the rectified left camera's frame against the raw one's: poses of the raw left
  // camera become poses of the rectified one by this rotation.
  const Rigid3d& rectified_from_raw_left() const { return rectified_from_raw_left_; }

  // `raw` and `rectified` are CV_8UC1 of the calibrated size (INVALID_ARGUMENT otherwise);
  // `rectified` is allocated when it is not.
  absl::Status RectifyLeft(const cv::Mat& raw, cv::Mat& rectified) const;
  absl::Status RectifyRight(const cv::Mat& raw, cv::Mat& rectified) const;

 private:
  // OpenCV's fixed-point maps of remap.
  struct Maps {
    cv::Mat pixels;
    cv::Mat fractions;
  };
  StereoRectifier() = default;
  absl::Status MakeAsOpenCv(const RawStereo& raw);
  absl::Status MakeOfFisheyes(const RawStereo& raw);
  absl::Status Rectify(const Maps& maps, const cv::Mat& raw, cv::Mat& rectified) const;

  Camera camera_;
  Rigid3d rectified_from_raw_left_;
  Maps left_;
  Maps right_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CAMERA_RECTIFICATION_H_
