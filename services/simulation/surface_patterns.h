// What each material looks like: reflectance as a function of the place on the surface. Every
// pattern is unique to its place and seed, has edges at several scales, and averages over a pixel.
#ifndef CORBSLAM_SERVICES_SIMULATION_SURFACE_PATTERNS_H_
#define CORBSLAM_SERVICES_SIMULATION_SURFACE_PATTERNS_H_

#include <array>
#include <cstdint>

#include "services/simulation/scene.h"

namespace corbslam {

constexpr int kLanes = 16;

// Sixteen places on surfaces, one a lane; lanes that hit nothing are not `hit`.
struct alignas(64) SurfacePacket {
  std::array<float, kLanes> u_m;
  std::array<float, kLanes> v_m;
  std::array<float, kLanes> pixel_u_m;
  std::array<float, kLanes> pixel_v_m;
  std::array<uint32_t, kLanes> seed;
  std::array<Material, kLanes> material;
  std::array<bool, kLanes> hit;
};

// Computes the reflectance, 0 to 1, of the lanes that hit something; it leaves the others as they
// are. It is the same on every processor.
void ComputeReflectance(const SurfacePacket& surface, std::array<float, kLanes>& reflectance);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SIMULATION_SURFACE_PATTERNS_H_
