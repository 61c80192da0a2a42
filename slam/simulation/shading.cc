#include "slam/simulation/shading.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace corbslam {
namespace {

// Places in a layer of clouds above the eye.
void FillSky(const RayPacket& rays, uint32_t seed, SurfacePacket& surface) {
  constexpr float kCloudHeight_m = 500;
  const float pixel = rays.pixel_right.norm();
  for (size_t i = 0; i < kLanes; ++i) {
    if (!rays.active[i] || surface.hit[i]) continue;
    const float x = rays.direction_x[i];
    const float y = rays.direction_y[i];
    const float z = rays.direction_z[i];
    const float length = std::sqrt(x * x + y * y + z * z);
    const float rise = std::max(-y / length, 0.0F) + 0.12F;
    surface.hit[i] = true;
    surface.material[i] = Material::kSky;
    surface.seed[i] = seed;
    surface.u_m[i] = kCloudHeight_m * x / (length * rise);
    surface.v_m[i] = kCloudHeight_m * z / (length * rise);
    surface.pixel_u_m[i] = kCloudHeight_m * pixel / rise;
    surface.pixel_v_m[i] = kCloudHeight_m * pixel / (rise * rise);
  }
}

// Distance takes contrast away: light of the air takes the place of the surface's.
float ThroughAir(float light, float depth_m) {
  constexpr float kRange_m = 900;
  constexpr float kAir = 0.75F;
  const float share = depth_m / (depth_m + kRange_m);
  return light + (kAir - light) * share;
}

}  // namespace

LightPacket ComputeLight(const RayCaster& caster, const MoverPoses* movers, const RayPacket& rays) {
  HitPacket hits;
  caster.Cast(rays, movers, hits);
  const bool sky = caster.scene().light.sky;
  if (sky) FillSky(rays, caster.scene().seed, hits.surface);
  std::array<float, kLanes> reflectance = {};
  ComputeReflectance(hits.surface, reflectance);
  LightPacket result;
  for (size_t i = 0; i < kLanes; ++i) {
    result.patch[i] = hits.patch[i];
    const bool surface = hits.depth_m[i] > 0;
    const float lit = surface ? hits.light[i] * reflectance[i] : reflectance[i];
    result.light[i] = surface && sky ? ThroughAir(lit, hits.depth_m[i]) : lit;
  }
  return result;
}

}  // namespace corbslam
