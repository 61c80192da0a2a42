// Lenses: which direction falls where in a picture, for pinholes that distort and for fisheyes.
#ifndef CORBSLAM_SLAM_CAMERA_LENS_H_
#define CORBSLAM_SLAM_CAMERA_LENS_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "slam/camera/camera.h"
#include "slam/camera/distortion.h"

namespace corbslam {

// The equidistant fisheye (Kannala and Brandt, PAMI 2006; OpenCV's fisheye, Kalibr's equidistant):
// a ray at the angle t from the optical axis falls at the distance t (1 + k1 t^2 + k2 t^4 + k3 t^6
// + k4 t^8) from the principal point, in focal lengths.
struct Equidistant {
  double k1 = 0;
  double k2 = 0;
  double k3 = 0;
  double k4 = 0;

  friend bool operator==(const Equidistant&, const Equidistant&) = default;
};

// Two unit spheres, their centres `xi` apart, then a pinhole shifted by alpha / (1 - alpha)
// (Usenko, Demmel and Cremers, 3DV 2018; Kalibr's ds).
struct DoubleSphere {
  double xi = 0;     // In (-1, 1].
  double alpha = 0;  // In [0, 1].

  friend bool operator==(const DoubleSphere&, const DoubleSphere&) = default;
};

// One unit sphere, seen from a point `xi` behind its centre, through a lens that distorts (Mei and
// Rives, ICRA 2007; Kalibr's omni). Focal lengths are those of that point's pinhole.
struct UnifiedSphere {
  double xi = 0;  // In [0, 10].
  RadialTangential distortion;

  friend bool operator==(const UnifiedSphere&, const UnifiedSphere&) = default;
};

using LensModel = std::variant<RadialTangential, Equidistant, DoubleSphere, UnifiedSphere>;

// INVALID_ARGUMENT names the coefficient, its value and its limits.
absl::Status Validate(const LensModel& model);

// Returns "radial-tangential", "equidistant", "double-sphere" or "unified".
absl::string_view NameOf(const LensModel& model);
// Returns "no distortion", or the name and each coefficient with its value.
std::string DescribeLens(const LensModel& model);

// Returns where a direction (x right, y down, z ahead; any length but 0) falls, in focal lengths
// from the principal point; nullopt where the lens, as far as the model describes it, doesn't see
// it: behind a pinhole, or beyond the angle from which on the model folds back.
std::optional<Eigen::Vector2d> SeenAt(const LensModel& model, const Eigen::Vector3d& direction);

// Inverts SeenAt: returns the unit vector that falls there; nullopt where none does.
std::optional<Eigen::Vector3d> DirectionOf(const LensModel& model, const Eigen::Vector2d& seen);

// A camera of pictures as they are recorded, through their lens.
struct RawCamera {
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  LensModel lens;

  friend bool operator==(const RawCamera&, const RawCamera&) = default;
};

// The same projections, in pixels.
std::optional<Eigen::Vector2d> ProjectRaw(const RawCamera& camera,
                                          const Eigen::Vector3d& direction);
std::optional<Eigen::Vector3d> UnprojectRaw(const RawCamera& camera, const Eigen::Vector2d& raw_px);

// Returns the ideal pixel of a raw pixel: both pictures have the intrinsics of `camera`. Nullopt
// where no pinhole sees it: more than 80 degrees from the axis, or nothing falls there. For
// radial-tangential lenses there is always one: where the model folds over (outside the lens's
// field of view) the nearest that is found.
std::optional<Eigen::Vector2d> UndistortPixel(const Camera& camera, const LensModel& lens,
                                              const Eigen::Vector2d& raw_px);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CAMERA_LENS_H_
