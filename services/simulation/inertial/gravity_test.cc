#include "services/simulation/inertial/gravity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace corbslam {
namespace {

using ::testing::HasSubstr;

constexpr TimeSpan kSpan = {0, 10'000'000'000};

// A body that sways and turns, in a world whose y points down.
Rigid3d Sway(int64_t time_ns) {
  const double t = 1e-9 * static_cast<double>(time_ns);
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.8 * std::sin(t),
                                               Eigen::Vector3d(1, 2, std::cos(t)).normalized())),
          {2 * std::sin(1.3 * t), 0.5 * std::cos(t), std::sin(0.7 * t)}};
}

// Maps from the world to a frame in which down is somewhere else.
const Rigid3d kFrameFromWorld = {
    Eigen::Quaterniond(Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, 0.2, -0.4).normalized())),
    {4, 5, 6}};

ImuSamples Biased() {
  ImuSamples samples = MeasureMotion(Sway, kSpan, 200);
  for (ImuSample& sample : samples) sample.specific_force_mps2 += Eigen::Vector3d(0.1, -0.2, 0.15);
  return samples;
}

TEST(EstimateGravityTest, FindsDownThroughABias) {
  const auto gravity = EstimateGravity(
      [](int64_t time_ns) { return kFrameFromWorld * Sway(time_ns); }, kSpan, Biased());
  ASSERT_TRUE(gravity.ok()) << gravity.status();
  const Eigen::Vector3d down = kFrameFromWorld.rotation * Eigen::Vector3d(0, kGravity_mps2, 0);
  EXPECT_LT((*gravity - down).norm(), 0.005);
}

TEST(EstimateGravityTest, RefusesSamplesOfAnotherMotion) {
  const auto message = [](const ImuMotion& motion, const ImuSamples& samples) {
    return std::string(EstimateGravity(motion, kSpan, samples).status().message());
  };
  EXPECT_THAT(message([](int64_t time_ns) { return Sway(time_ns + 1'500'000'000); }, Biased()),
              HasSubstr("not of the poses' motion"));
  ImuSamples in_g = Biased();
  for (ImuSample& sample : in_g) sample.specific_force_mps2 /= kGravity_mps2;
  EXPECT_THAT(message(Sway, in_g), HasSubstr("gravity comes out as"));
  ImuSamples other_times = Biased();
  for (ImuSample& sample : other_times) sample.timestamp_ns += 8'000'000'000;
  EXPECT_THAT(message(Sway, other_times), HasSubstr("less than three seconds"));
}

}  // namespace
}  // namespace corbslam
