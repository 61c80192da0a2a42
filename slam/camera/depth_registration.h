// Moves depth pictures into the view of the camera that takes the colour or grey picture.
#ifndef CORBSLAM_SLAM_CAMERA_DEPTH_REGISTRATION_H_
#define CORBSLAM_SLAM_CAMERA_DEPTH_REGISTRATION_H_

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "slam/camera/lens.h"
#include "slam/geometry/rigid3.h"

namespace corbslam {

// A camera of depth beside one of colour, each with its own lens and size.
struct DepthGeometry {
  RawCamera depth;
  cv::Size depth_px;
  RawCamera colour;
  cv::Size colour_px;
  Rigid3d colour_from_depth;  // Metres.
};

// INVALID_ARGUMENT names the field and its value: an impossible camera, or cameras that are more
// than a metre apart.
absl::Status Validate(const DepthGeometry& geometry);

// Depths are along the axis of their camera, as depth cameras measure them. Immutable; any thread.
class DepthRegistration {
 public:
  // INVALID_ARGUMENT for an impossible geometry.
  static absl::StatusOr<DepthRegistration> Make(const DepthGeometry& geometry);

  // Takes CV_16UC1 in units of `units_per_m`, or CV_32FC1 in metres; 0, 65535 (of 16 bits), NaN
  // and what isn't above 0 are no depth. Returns the same type, of the colour picture's size and
  // through its lens, 0 where there is none: each depth pixel is moved with all that it covers, the
  // nearest wins, and nothing is guessed where no depth pixel falls. INVALID_ARGUMENT for a picture
  // of another type or size.
  absl::StatusOr<cv::Mat> Register(const cv::Mat& depth, double units_per_m) const;

 private:
  // Where a depth pixel looks, in the colour camera's frame.
  struct Ray {
    Eigen::Vector3f per_metre;  // What a metre of depth moves the point by; NaN: looks nowhere.
    // Half the width and height of what it covers in the colour picture, very far away, times the
    // ray's z.
    Eigen::Vector2f reach_px;
  };

  explicit DepthRegistration(const DepthGeometry& geometry);
  void MakeRays();
  Ray RayOf(int x, int y) const;
  // Returns false where the colour lens doesn't see the point.
  bool Project(const Eigen::Vector3f& point, Eigen::Vector2f& at_px) const;
  template <typename Depth>
  cv::Mat RegisterAs(const cv::Mat& depth, float units_per_m) const;

  DepthGeometry geometry_;
  Eigen::Vector3f translation_;
  // The squared radius up to which a radial-tangential colour lens is one to one.
  float most_r2_ = 0;
  std::vector<Ray> rays_;  // By rows.
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_CAMERA_DEPTH_REGISTRATION_H_
