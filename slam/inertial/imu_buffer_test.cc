#include "slam/inertial/imu_buffer.h"

#include <gtest/gtest.h>

namespace corbslam {
namespace {

constexpr int64_t kMs = 1'000'000;

ImuSample At(int64_t ms, double rate) {
  return {ms * kMs, Eigen::Vector3d(rate, 0, 0), Eigen::Vector3d(0, rate, 0)};
}

ImuBuffer Every10Ms() {
  ImuBuffer buffer;
  ImuSamples samples;
  for (int i = 0; i <= 10; ++i) samples.push_back(At(100 + 10 * i, i));
  buffer.Add(samples);
  return buffer;
}

double Turned(const std::vector<ImuStep>& steps) {
  double turned = 0;
  for (const ImuStep& step : steps) turned += step.duration_s * step.mean.angular_velocity_rps.x();
  return turned;
}

TEST(ImuBufferTest, IntegratesLinesBetweenSamples) {
  const ImuBuffer buffer = Every10Ms();
  const std::vector<ImuStep> steps = buffer.Between(103 * kMs, 118 * kMs);
  ASSERT_EQ(steps.size(), 2);
  EXPECT_NEAR(steps[0].duration_s, 0.007, 1e-12);
  EXPECT_NEAR(steps[1].duration_s, 0.008, 1e-12);
  EXPECT_EQ(steps[1].mean.timestamp_ns, 118 * kMs);
  // The rate grows by 1 in 10 ms: the mean of 0.3 and 1.8 for 15 ms.
  EXPECT_NEAR(Turned(steps), 1.05 * 0.015, 1e-12);
}

TEST(ImuBufferTest, PartsAddUpToTheWhole) {
  const ImuBuffer buffer = Every10Ms();
  const double whole = Turned(buffer.Between(101 * kMs, 199 * kMs));
  const double parts =
      Turned(buffer.Between(101 * kMs, 150 * kMs)) + Turned(buffer.Between(150 * kMs, 199 * kMs));
  EXPECT_NEAR(whole, parts, 1e-12);
}

TEST(ImuBufferTest, HasNothingBeforeTheFirstSample) {
  EXPECT_TRUE(Every10Ms().Between(99 * kMs, 150 * kMs).empty());
  EXPECT_TRUE(ImuBuffer().Between(0, kMs).empty());
}

TEST(ImuBufferTest, TheNewestSampleLastsForALittle) {
  const std::vector<ImuStep> steps = Every10Ms().Between(190 * kMs, 240 * kMs);
  ASSERT_EQ(steps.size(), 2);
  EXPECT_NEAR(steps[1].mean.angular_velocity_rps.x(), 10, 1e-12);
  EXPECT_TRUE(Every10Ms().Between(190 * kMs, 251 * kMs).empty());
}

TEST(ImuBufferTest, NothingGoesOverAGap) {
  ImuBuffer buffer = Every10Ms();
  buffer.Add({At(260, 1), At(270, 1)});
  EXPECT_TRUE(buffer.Between(190 * kMs, 265 * kMs).empty());
  EXPECT_TRUE(buffer.Between(210 * kMs, 230 * kMs).empty());
  EXPECT_EQ(buffer.Between(260 * kMs, 270 * kMs).size(), 1);
  EXPECT_EQ(buffer.Between(180 * kMs, 200 * kMs).size(), 2);
}

TEST(ImuBufferTest, LeavesOutSamplesThatCameBefore) {
  ImuBuffer buffer = Every10Ms();
  buffer.Add({At(200, 99), At(150, 99)});
  EXPECT_NEAR(Turned(buffer.Between(140 * kMs, 200 * kMs)), 7 * 0.06, 1e-12);
  EXPECT_EQ(buffer.newest_ns(), 200 * kMs);
}

TEST(ImuBufferTest, ForgetsAllButWhatIsNeededFromATimeOn) {
  ImuBuffer buffer = Every10Ms();
  buffer.Forget(155 * kMs);
  EXPECT_TRUE(buffer.Between(149 * kMs, 160 * kMs).empty());
  EXPECT_EQ(buffer.Between(155 * kMs, 160 * kMs).size(), 1);
}

}  // namespace
}  // namespace corbslam
