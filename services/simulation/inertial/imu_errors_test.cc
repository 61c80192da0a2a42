#include "services/simulation/inertial/imu_errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace corbslam {
namespace {

// At rest, without errors, 200 a second.
ImuSamples Rest(int count) {
  ImuSamples samples;
  for (int i = 0; i < count; ++i) {
    samples.push_back({int64_t{5'000'000} * i, {0, 0, 0}, {0, -kGravity_mps2, 0}});
  }
  return samples;
}

SimulatedImu Of(ImuGrade grade) {
  SimulatedImu imu;
  imu.grade = grade;
  return imu;
}

struct Spread {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double deviation = 0;  // Of all axes.
};
Spread GyroSpread(const ImuSamples& samples) {
  Spread spread;
  const auto count = static_cast<double>(samples.size());
  for (const ImuSample& sample : samples) spread.mean += sample.angular_velocity_rps / count;
  double squares = 0;
  for (const ImuSample& sample : samples) {
    squares += (sample.angular_velocity_rps - spread.mean).squaredNorm();
  }
  spread.deviation = std::sqrt(squares / count / 3);
  return spread;
}

bool AreSame(const ImuSamples& a, const ImuSamples& b) {
  if (a.size() != b.size()) return false;
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i].timestamp_ns != b[i].timestamp_ns ||
        a[i].angular_velocity_rps != b[i].angular_velocity_rps ||
        a[i].specific_force_mps2 != b[i].specific_force_mps2) {
      return false;
    }
  }
  return true;
}

TEST(ImuErrorsTest, TheIdealOneHasNone) {
  EXPECT_TRUE(AreSame(WithErrors(Of(ImuGrade::kIdeal), 1, Rest(100)), Rest(100)));
}

TEST(ImuErrorsTest, SeedsErrDifferentlyAndEachTheSame) {
  const SimulatedImu imu = Of(ImuGrade::kPhone);
  EXPECT_TRUE(AreSame(WithErrors(imu, 1, Rest(100)), WithErrors(imu, 1, Rest(100))));
  EXPECT_FALSE(AreSame(WithErrors(imu, 1, Rest(100)), WithErrors(imu, 2, Rest(100))));
}

TEST(ImuErrorsTest, NoiseHasTheDensityThatTheRobotIsTold) {
  SimulatedImu imu = Of(ImuGrade::kGood);
  imu.bias = GyroAccel{};
  const double told = ToldImu(imu).noise.gyro;
  EXPECT_NEAR(GyroSpread(WithErrors(imu, 1, Rest(20'000))).deviation, told * std::sqrt(200),
              0.05 * told * std::sqrt(200));
}

TEST(ImuErrorsTest, BiasesWalkAsTold) {
  SimulatedImu imu = Of(ImuGrade::kGood);
  imu.bias = GyroAccel{};
  constexpr int kSeconds = 100;
  double squares = 0;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const ImuSamples samples = WithErrors(imu, seed, Rest(200 * kSeconds));
    // The mean over the last second has little of the noise.
    Eigen::Vector3d bias(0, kGravity_mps2, 0);
    for (auto sample = samples.end() - 200; sample != samples.end(); ++sample) {
      bias += sample->specific_force_mps2 / 200;
    }
    squares += bias.squaredNorm();
  }
  const double expected = ToldImu(imu).noise.accel_walk * std::sqrt(kSeconds);
  EXPECT_NEAR(std::sqrt(squares / 60), expected, 0.3 * expected);
}

TEST(ImuErrorsTest, BiasesAtTurnOnAreOfTheSeed) {
  SimulatedImu imu = Of(ImuGrade::kIdeal);
  imu.bias = GyroAccel{0.02, 0.3};
  double squares = 0;
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    const ImuSamples samples = WithErrors(imu, seed, Rest(2));
    EXPECT_EQ(samples[0].angular_velocity_rps, samples[1].angular_velocity_rps);
    squares += samples[0].angular_velocity_rps.squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(squares / 300), 0.02, 0.003);
}

TEST(ImuErrorsTest, WarmingMovesTheBiasesToAnEnd) {
  SimulatedImu imu = Of(ImuGrade::kIdeal);
  imu.warming = {{0.01, 0.2}, 2};
  const ImuSamples samples = WithErrors(imu, 1, Rest(4001));
  EXPECT_EQ(samples.front().angular_velocity_rps.norm(), 0);
  EXPECT_NEAR(std::abs(samples[400].angular_velocity_rps.x()), 0.01 * (1 - std::exp(-1)), 1e-9);
  EXPECT_NEAR(std::abs(samples.back().specific_force_mps2.z()), 0.2, 1e-4);
}

TEST(ImuErrorsTest, VibrationSwingsAsFarAsAPeriodLeavesOfIt) {
  SimulatedImu imu = Of(ImuGrade::kIdeal);
  imu.vibration = {90, {0, 4}};
  double most = 0;
  for (const ImuSample& sample : WithErrors(imu, 1, Rest(2000))) {
    most = std::max(most, std::abs(sample.specific_force_mps2.x()));
  }
  const double half_turned = 3.14159265 * 90 / 200;
  EXPECT_NEAR(most, 4 * std::sin(half_turned) / half_turned, 0.02);
}

TEST(ImuErrorsTest, CutsOffWhatIsBeyondTheRange) {
  SimulatedImu imu = Of(ImuGrade::kIdeal);
  imu.range = {0, 9};
  const ImuSamples samples = WithErrors(imu, 1, Rest(1));
  EXPECT_EQ(samples[0].specific_force_mps2, Eigen::Vector3d(0, -9, 0));
}

TEST(ImuErrorsTest, StampsAreLateAndGapsAreOfTheTrueTime) {
  SimulatedImu imu = Of(ImuGrade::kGood);
  const ImuSamples whole = WithErrors(imu, 1, Rest(100));
  imu.late_s = 0.02;
  imu.gaps = {{0.3, 0.01}, {0.1, 0.1}};
  const ImuSamples samples = WithErrors(imu, 1, Rest(100));
  ASSERT_EQ(samples.size(), 100u - 20 - 2);
  EXPECT_EQ(samples[0].timestamp_ns, 20'000'000);
  EXPECT_EQ(samples[19].timestamp_ns, 115'000'000);
  EXPECT_EQ(samples[20].timestamp_ns, 220'000'000);
  // What is left is what it would have been.
  EXPECT_EQ(samples[20].angular_velocity_rps, whole[40].angular_velocity_rps);
}

}  // namespace
}  // namespace corbslam
