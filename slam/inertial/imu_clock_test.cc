#include "slam/inertial/imu_clock.h"

#include <gtest/gtest.h>

#include "slam/inertial/testing/felt_path.h"

namespace corbslam {
namespace {

constexpr int64_t kClockFrame_ns = 50'000'000;
constexpr int64_t kClockUntil_ns = 10'000'000'000;

// An IMU whose stamps are late by so much, beside a camera.
ImuClock Late(int64_t late_ns, const ImuPath& path = FlownPath) {
  ImuClock clock;
  ImuSamples samples = FeltAlong(path, 0, kClockUntil_ns, 200, {}, {{0.01, 0, 0}, {}}, 1);
  for (ImuSample& sample : samples) sample.timestamp_ns += late_ns;
  clock.Add(samples);
  for (int64_t now_ns = kClockFrame_ns; now_ns < kClockUntil_ns; now_ns += kClockFrame_ns) {
    const Rigid3d moved = PathAt(path, now_ns - kClockFrame_ns).Inverse() * PathAt(path, now_ns);
    clock.AddTurn(now_ns - kClockFrame_ns, now_ns,
                  LogSO3(moved.rotation) / (1e-9 * static_cast<double>(kClockFrame_ns)));
  }
  return clock;
}

class LateClockTest : public ::testing::TestWithParam<int64_t> {};

TEST_P(LateClockTest, FindsTheOffset) {
  const auto fit = Late(GetParam()).Fit();
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(static_cast<double>(fit->offset_ns), static_cast<double>(-GetParam()), 4e6);
  EXPECT_GT(fit->correlation, 0.98);
}

INSTANTIATE_TEST_SUITE_P(Offsets, LateClockTest,
                         ::testing::Values(-300'000'000, -100'000'000, 150'000'000, 400'000'000));

TEST(ImuClockTest, StampsThatAreRightStayAsTheyAre) {
  EXPECT_FALSE(Late(0).Fit().has_value());
  EXPECT_FALSE(Late(3'000'000).Fit().has_value());
}

TEST(ImuClockTest, WhatDoesNotTurnTellsNothing) {
  EXPECT_FALSE(Late(100'000'000, [](double) { return Rigid3d(); }).Fit().has_value());
  EXPECT_FALSE(ImuClock().Fit().has_value());
}

TEST(ImuClockTest, KeepsTheNewestSecondsAlone) {
  ImuClock clock;
  clock.Add(FeltAlong(FlownPath, 0, 30'000'000'000, 200, {}, {}, 1));
  EXPECT_EQ(clock.samples().front().timestamp_ns, 18'000'000'000);
  EXPECT_EQ(clock.samples().back().timestamp_ns, 30'000'000'000);
}

}  // namespace
}  // namespace corbslam
