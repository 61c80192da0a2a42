// The camera that recorded the pictures from which those of a Camera were made.
//
// Keyframes, their poses and all that is estimated are of the Camera, whose pictures are
// undistorted and, for stereo, rectified. People mean another frame: that of the camera as it is
// built into the robot and as ground truth names it, or the robot's body.
#ifndef CORBSLAM_SLAM_CAMERA_RECORDED_CAMERA_H_
#define CORBSLAM_SLAM_CAMERA_RECORDED_CAMERA_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "slam/camera/camera.h"
#include "slam/camera/lens.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

struct RecordedCamera {
  // Lens of the recorded pictures; for a stereo pair, of the left ones. They have the Camera's
  // size.
  RawCamera lens;
  // Rotation by which rectification turned the camera: x_in_camera = camera_from_recorded *
  // x_in_recorded. Both frames have one centre.
  Rigid3d camera_from_recorded;
  // EuRoC's T_BS; it is absent where nobody said where the body is.
  std::optional<Rigid3d> body_from_recorded;

  // Compares every field to the bit.
  friend bool operator==(const RecordedCamera& a, const RecordedCamera& b);
};

// INVALID_ARGUMENT names the field and its value where the camera is impossible.
absl::Status Validate(const RecordedCamera& recorded);

// Describes the camera of pictures that were used as they were recorded.
RecordedCamera AsRecorded(const Camera& camera);

// Returns the recorded picture's pixel where the Camera has `pixel`; (-1, -1) where a fisheye, as
// far as its model describes it, doesn't see that.
Eigen::Vector2d RecordedPixel(const Camera& camera, const RecordedCamera& recorded,
                              const Eigen::Vector2d& pixel);

// Says which frame poses are of.
enum class PosesOf {
  kRecordedCamera,   // The camera as it recorded; for a stereo pair, the left one.
  kRectifiedCamera,  // The Camera.
  kBody,
};

// Returns what options are called: "camera", "rectified", "body".
absl::string_view ToString(PosesOf poses_of);
// INVALID_ARGUMENT names the three that there are.
absl::StatusOr<PosesOf> ParsePosesOf(absl::string_view text);
// Returns "the camera as recorded (of a stereo pair the left one)", "the rectified camera ...", or
// "the body".
absl::string_view Describe(PosesOf poses_of);

// Returns camera_from_wanted, with x_in_camera = camera_from_wanted * x_in_wanted; nullopt where
// both are the same frame. Without `recorded` the Camera is taken to be the one that recorded.
// FAILED_PRECONDITION: the body is wanted and not known.
absl::StatusOr<std::optional<Rigid3d>> CameraFromWanted(
    const std::optional<RecordedCamera>& recorded, PosesOf wanted);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CAMERA_RECORDED_CAMERA_H_
