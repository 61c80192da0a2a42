#include "services/simulation/inertial/measured_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;

TEST(MeasureMotionTest, AtRestGravityIsHeldUp) {
  const Rigid3d still = {Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX())),
                         {1, 2, 3}};
  const ImuSamples samples =
      MeasureMotion([&](int64_t) { return still; }, {0, kSecond_ns / 10}, 200);
  ASSERT_EQ(samples.size(), 21u);
  for (const ImuSample& sample : samples) {
    EXPECT_EQ(sample.angular_velocity_rps.norm(), 0);
    const Eigen::Vector3d upwards = still.rotation * sample.specific_force_mps2;
    EXPECT_LT((upwards - Eigen::Vector3d(0, -kGravity_mps2, 0)).norm(), 1e-9);
  }
  EXPECT_EQ(samples[3].timestamp_ns, 15'000'000);
}

TEST(MeasureMotionTest, OnACircleItIsPulledInwards) {
  constexpr double kRadius_m = 3;
  constexpr double kRate_rps = 0.7;
  const auto circle = [](int64_t time_ns) -> Rigid3d {
    const double angle = kRate_rps * 1e-9 * static_cast<double>(time_ns);
    return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitY())),
            {kRadius_m * std::cos(angle), 0, -kRadius_m * std::sin(angle)}};
  };
  for (const ImuSample& sample : MeasureMotion(circle, {kSecond_ns, 3 * kSecond_ns}, 250)) {
    EXPECT_LT((sample.angular_velocity_rps - Eigen::Vector3d(0, kRate_rps, 0)).norm(), 1e-6);
    EXPECT_LT((sample.specific_force_mps2 -
               Eigen::Vector3d(-kRadius_m * kRate_rps * kRate_rps, -kGravity_mps2, 0))
                  .norm(),
              0.01);
  }
}

TEST(MeasureMotionTest, LooksAtNothingOutsideTheSpan) {
  const TimeSpan span = {12'345'678, 112'345'679};
  int64_t earliest_ns = kSecond_ns;
  int64_t latest_ns = 0;
  const auto motion = [&](int64_t time_ns) -> Rigid3d {
    earliest_ns = std::min(earliest_ns, time_ns);
    latest_ns = std::max(latest_ns, time_ns);
    return {};
  };
  const ImuSamples samples = MeasureMotion(motion, span, 200);
  EXPECT_EQ(samples.front().timestamp_ns, 15'000'000);
  EXPECT_EQ(samples.back().timestamp_ns, 110'000'000);
  EXPECT_GE(earliest_ns, span.first_ns);
  EXPECT_LE(latest_ns, span.last_ns);
  EXPECT_TRUE(MeasureMotion(motion, {}, 200).empty());
}

TEST(MeasureMotionTest, SamplesAddUpToAVelocityThatJumps) {
  // Knocked at 0.1012 s, between two samples.
  const auto knocked = [](int64_t time_ns) -> Rigid3d {
    const double since_s = std::max(0.0, 1e-9 * static_cast<double>(time_ns) - 0.1012);
    return {Eigen::Quaterniond::Identity(), {2 * since_s, 0, 0}};
  };
  double sum_mps = 0;
  for (const ImuSample& sample : MeasureMotion(knocked, {0, kSecond_ns}, 200)) {
    sum_mps += sample.specific_force_mps2.x() / 200;
  }
  EXPECT_NEAR(sum_mps, 2, 1e-9);
  EXPECT_NEAR(VelocityAt(knocked, {0, kSecond_ns}, kSecond_ns / 2).x(), 2, 1e-9);
}

}  // namespace
}  // namespace corbslam
