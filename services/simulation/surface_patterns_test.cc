#include "services/simulation/surface_patterns.h"

#include <gtest/gtest.h>

#include <string_view>

#include "services/simulation/dice.h"
#include "slam/util/checksum.h"

namespace corbslam {
namespace {

constexpr int kMaterials = static_cast<int>(Material::kSky) + 1;

// Places near and far from the surface's origin, seen from near and far.
SurfacePacket RandomPacket(Dice* dice) {
  SurfacePacket packet;
  const double reach_m = dice->Chance(0.5) ? 5 : 800;
  const double pixel_m = dice->Chance(0.5) ? 0.004 : 0.3;
  for (size_t lane = 0; lane < kLanes; ++lane) {
    packet.u_m[lane] = dice->Uniformf(-reach_m, reach_m);
    packet.v_m[lane] = dice->Uniformf(-reach_m, reach_m);
    packet.pixel_u_m[lane] = dice->Uniformf(0, pixel_m);
    packet.pixel_v_m[lane] = dice->Uniformf(0, pixel_m);
    packet.seed[lane] = dice->Seed();
    packet.material[lane] = static_cast<Material>(dice->Integer(0, kMaterials - 1));
    packet.hit[lane] = dice->Chance(0.9);
  }
  return packet;
}

TEST(SurfacePatternsTest, ReflectanceIsWithinBoundsAndOfPlacesThatWereHit) {
  Dice dice(3);
  for (int round = 0; round < 500; ++round) {
    const SurfacePacket packet = RandomPacket(&dice);
    std::array<float, kLanes> reflectance;
    reflectance.fill(-7);
    ComputeReflectance(packet, reflectance);
    for (size_t lane = 0; lane < kLanes; ++lane) {
      if (packet.hit[lane]) {
        EXPECT_GE(reflectance[lane], 0);
        EXPECT_LE(reflectance[lane], 1);
      } else {
        EXPECT_EQ(reflectance[lane], -7);
      }
    }
  }
}

// The checksum was taken on x86-64 with AVX2. Another processor, or another way to arrange the
// arithmetic, must give the same bits: sequences that are simulated by name are the same
// everywhere.
TEST(SurfacePatternsTest, BitsAreTheSameOnEveryProcessor) {
  Dice dice(11);
  uint32_t checksum = 0;
  for (int round = 0; round < 2000; ++round) {
    std::array<float, kLanes> reflectance = {};
    ComputeReflectance(RandomPacket(&dice), reflectance);
    checksum = ExtendCrc32c(
        checksum, {reinterpret_cast<const char*>(reflectance.data()), sizeof(reflectance)});
  }
  EXPECT_EQ(checksum, 0x2985c5d2u);
}

}  // namespace
}  // namespace corbslam
