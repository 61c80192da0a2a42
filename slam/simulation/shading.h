// The light that comes to the eye along rays.
#ifndef CORBSLAM_SLAM_SIMULATION_SHADING_H_
#define CORBSLAM_SLAM_SIMULATION_SHADING_H_

#include <array>
#include <cstdint>

#include "slam/simulation/ray_caster.h"

namespace corbslam {

struct LightPacket {
  std::array<float, kLanes> light;     // 1: a white surface in full sun.
  std::array<uint32_t, kLanes> patch;  // As HitPacket's.
};

// Of the active lanes; the others' are 0.
LightPacket ComputeLight(const RayCaster& caster, const MoverPoses* movers, const RayPacket& rays);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SIMULATION_SHADING_H_
