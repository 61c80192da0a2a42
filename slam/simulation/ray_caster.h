// A scene made ready for ray casting: Intel's Embree finds what a ray hits first.
#ifndef CORBSLAM_SLAM_SIMULATION_RAY_CASTER_H_
#define CORBSLAM_SLAM_SIMULATION_RAY_CASTER_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "slam/simulation/scene.h"
#include "slam/simulation/surface_patterns.h"

namespace corbslam {

// Sixteen rays from one eye. Directions reach depth 1 (along the camera's z), so distances along
// them are depths.
struct alignas(64) RayPacket {
  Eigen::Vector3f origin;
  std::array<float, kLanes> direction_x;
  std::array<float, kLanes> direction_y;
  std::array<float, kLanes> direction_z;
  std::array<bool, kLanes> active;
  // What a direction changes by from one pixel to the next.
  Eigen::Vector3f pixel_right;
  Eigen::Vector3f pixel_down;
};

struct HitPacket {
  SurfacePacket surface;
  std::array<float, kLanes> depth_m;  // 0: nothing was hit.
  std::array<float, kLanes> light;    // What falls on the surface times its tone.
  // Equal for places of one patch, different for most others; 0: nothing was hit.
  std::array<uint32_t, kLanes> patch;
};

class MoverPoses;

// Immutable; Cast may be called from any thread.
class RayCaster {
 public:
  // INVALID_ARGUMENT, naming the field, for a mesh index out of range, an empty mover path or
  // numbers that aren't finite.
  static absl::StatusOr<std::unique_ptr<RayCaster>> Make(Scene scene);
  virtual ~RayCaster() = default;

  virtual const Scene& scene() const = 0;
  // The movers where they are at a time; null where the scene has none.
  virtual std::shared_ptr<const MoverPoses> PlaceMovers(double time_s) const = 0;
  virtual void Cast(const RayPacket& rays, const MoverPoses* movers, HitPacket& hits) const = 0;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SIMULATION_RAY_CASTER_H_
