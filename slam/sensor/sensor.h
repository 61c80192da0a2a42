// Turns the images of a camera into features, by one interface for stereo and RGB-D, whose features
// have depths, and for one camera alone, whose have none.
#ifndef CORBSLAM_SLAM_SENSOR_SENSOR_H_
#define CORBSLAM_SLAM_SENSOR_SENSOR_H_

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <variant>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/camera/camera.h"
#include "slam/camera/lens.h"
#include "slam/camera/recorded_camera.h"
#include "slam/camera/rectification.h"
#include "slam/features/keypoint.h"
#include "slam/features/orb_extractor.h"
#include "slam/inertial/imu.h"

namespace corbslam {

// What a sensor sees at one time. Matrices are shared, not copied.
struct SensorImages {
  int64_t timestamp_ns = 0;
  cv::Mat grey = {};   // CV_8UC1; the left one of a stereo pair.
  cv::Mat right = {};  // CV_8UC1; stereo only.
  // Depth for RGB-D only, registered to `grey`: CV_16UC1 in units of depth_units_per_m, or CV_32FC1
  // in metres; 0, 65535 (of 16 bits) and NaN mean none.
  cv::Mat depth = {};
  // Measured since the images before, those that were passed over among them, up to the first
  // sample at or after these images' time where that came already; stamped by the camera's clock.
  // Empty where the rig has no IMU.
  ImuSamples imu = {};
};

// Says which parts of the recorded (left) picture belong to the robot itself and are never used:
// CV_8UC1 of the picture's size, 0 there. Empty: none.
using PictureMask = cv::Mat;

struct StereoCalibration {
  // Camera of the rectified pair, with baseline_m > 0. With `raw` set only close_depth_m is read,
  // when > 0: the rest follows from the rectification.
  Camera camera = {};
  // Calibration of the raw pair where the images come raw and need rectifying.
  std::optional<RawStereo> raw = {};
  // Number of columns by which the right camera's principal point lies further right than the left
  // one's in a rectified pair; each disparity is too small by so much. A pair may have such an
  // offset: those that are rectified to look at one point do.
  double right_cx_offset_px = 0;
  // Pose of the left camera as it recorded, where the calibration says it (EuRoC's T_BS).
  std::optional<Rigid3d> body_from_raw_left = {};
  PictureMask mask = {};
  std::optional<ImuCalibration> imu = {};
};

struct RgbdCalibration {
  // Its baseline_m is the virtual one that makes disparities of depths.
  Camera camera = {};
  // Lens of the raw grey image, which has the camera's intrinsics.
  LensModel lens = {};
  // Scale of CV_16UC1 depth images.
  double depth_units_per_m = 5000;
  // Pose of the grey camera, where the calibration says it.
  std::optional<Rigid3d> body_from_raw = {};
  PictureMask mask = {};
  std::optional<ImuCalibration> imu = {};
};

// One camera alone: no depths, and maps without scale.
struct MonocularCalibration {
  // Its baseline_m and close_depth_m are 0.
  Camera camera = {};
  // Lens of the raw grey image, which has the camera's intrinsics.
  LensModel lens = {};
  // Pose of the camera, where the calibration says it.
  std::optional<Rigid3d> body_from_raw = {};
  PictureMask mask = {};
  std::optional<ImuCalibration> imu = {};
};

using SensorCalibration = std::variant<StereoCalibration, RgbdCalibration, MonocularCalibration>;

// In the order of SensorCalibration's alternatives.
enum class SensorKind { kStereo, kRgbd, kMonocular };

inline SensorKind KindOf(const SensorCalibration& calibration) {
  return static_cast<SensorKind>(calibration.index());
}

// Returns the (left) camera of a pair or of an RGB-D camera alone, as it records.
MonocularCalibration FirstCameraOf(const SensorCalibration& calibration);

struct SensorOptions {
  OrbOptions orb = {};
  // Changes speed only: a second thread shares the work.
  bool parallel = true;
};

// Thread-compatible: one thread may use it at a time.
class Sensor {
 public:
  virtual ~Sensor() = default;

  // Returns the camera that keypoints refer to: undistorted, rectified.
  virtual const Camera& camera() const = 0;

  // Returns keypoints in pixels of camera(), with disparity_px set where depth is known.
  // INVALID_ARGUMENT names the image, what was expected and what was given, where an image has a
  // wrong size or type.
  virtual absl::StatusOr<Features> Process(const SensorImages& images) = 0;

  // Returns the (left) picture that Process looks for features in: raw, or rectified from a raw
  // pair. Its pixels are good until the next call. Errors as those of Process.
  virtual absl::StatusOr<cv::Mat> Picture(const SensorImages& images) = 0;
  // Returns where in that picture falls what an ideal pixel of camera() sees; nullopt where the
  // lens does not see it, the picture ends or the mask covers it.
  virtual std::optional<Eigen::Vector2d> InPicture(const Eigen::Vector2d& ideal_px) const = 0;
  // Returns a keypoint of camera() of one in that picture, with its disparity where the images say
  // its depth without a search: of RGB-D. Nullopt where no pinhole sees it.
  virtual std::optional<Keypoint> FromPicture(const SensorImages& images,
                                              const Keypoint& in_picture) const = 0;

  // Rows by which Process moves the right picture of a pair up, since its counterparts say beyond
  // doubt that it lies lower than the calibration has it (row_offset.h); 0 for other sensors.
  virtual double row_correction_px() const { return 0; }

  // Replaces the calibration's mask. INVALID_ARGUMENT as CheckMask; then the one before stays.
  virtual absl::Status SetMask(const PictureMask& mask) = 0;
};

// Returns the camera that recorded the (left) pictures of a sensor's camera(). INVALID_ARGUMENT
// where the calibration is impossible.
absl::StatusOr<RecordedCamera> RecordedCameraOf(const SensorCalibration& calibration);

// INVALID_ARGUMENT where the calibration or the options are impossible.
absl::StatusOr<std::unique_ptr<Sensor>> MakeSensor(const SensorCalibration& calibration,
                                                   const SensorOptions& options);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_SENSOR_H_
