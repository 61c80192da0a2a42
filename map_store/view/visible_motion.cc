#include "map_store/view/visible_motion.h"

#include <cmath>

namespace corbslam::map_store {
namespace {

constexpr double kVisible_px = 1;

// Returns the distance up to which depths are well known; a unit of the map's where the camera
// knows none.
double CloseDepth(const Camera& camera) {
  return camera.close_depth_m > 0 ? camera.close_depth_m : 1;
}

bool IsSame(const Similarity3d& a, const Similarity3d& b) {
  return a.scale == b.scale && a.rotation.coeffs() == b.rotation.coeffs() &&
         a.translation == b.translation;
}

}  // namespace

bool IsSeenToMove(const Similarity3d& a, const Similarity3d& b, const Camera& camera) {
  // Nearly all of them stay to the bit.
  if (IsSame(a, b)) return false;
  const Similarity3d motion = b * a.Inverse();
  const double angle = RotationAngle(motion.rotation) + std::abs(motion.scale - 1) +
                       motion.translation.norm() / CloseDepth(camera);
  return camera.fx_px * angle > kVisible_px;
}

double LeastVisibleMotion(const Eigen::Vector3d& position_in_camera, const Camera& camera) {
  return kVisible_px * position_in_camera.norm() / camera.fx_px;
}

}  // namespace corbslam::map_store
