// Asks whether a frame's pose holds whatever camera took it: whoever asks where a picture was taken
// may give another camera's numbers, and what agrees with these is then only what happens to.
#ifndef CORBSLAM_SLAM_VERIFICATION_CAMERA_CHECK_H_
#define CORBSLAM_SLAM_VERIFICATION_CAMERA_CHECK_H_

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "absl/types/span.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/keyframe.h"
#include "slam/map/map_point.h"
#include "slam/optimisation/camera_fit.h"

namespace corbslam {

struct CameraCheckOptions {
  uint64_t seed = 1;
  // A camera that is free to be any must not find so many times the points of the frame's own.
  double max_gain = 1.5;
  // Beyond these the pose is not determined by points whose camera nobody vouches for: its place,
  // as a share of the median depth of what agrees, and its rotation.
  double max_position_share = 0.06;
  double max_rotation_rad = 0.03;
};

struct CameraCheck {
  enum class Verdict {
    kAgrees,
    // With another camera the pose would be elsewhere, and the points do not say which is right.
    kInDoubt,
    // The points agree with another camera beyond doubt.
    kAnother,
  };
  Verdict verdict = Verdict::kInDoubt;
  // The camera that most points agree with; nullopt where too few do.
  std::optional<CameraFit> fit;
  // The covariance of a perturbation on the left of the pose that was asked about; it is true
  // whatever camera it was.
  std::optional<Matrix6d> covariance;
  size_t inliers = 0;  // Points that agree with the fitted camera.
  // Whether many more points agree with the fitted camera than with the frame's own
  // (CameraCheckOptions::max_gain).
  bool gains = false;
};

// `agreeing` are those that agree with the frame's own camera at `camera_from_map`: of all cameras
// they say least about another one, as they were chosen by this one. So a camera is fitted freely
// to `alike`, the pairs that only look alike (best first), of which many may be wrong, and what it
// has in view of `points` is sought with it. Deterministic and pure; it takes milliseconds.
CameraCheck CheckCamera(const Keyframe& frame, const std::vector<const MapPoint*>& points,
                        const Rigid3d& camera_from_map, absl::Span<const PoseObservation> agreeing,
                        absl::Span<const PoseObservation> alike,
                        const CameraCheckOptions& options = {});

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VERIFICATION_CAMERA_CHECK_H_
