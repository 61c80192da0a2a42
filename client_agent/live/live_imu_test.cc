#include "client_agent/live/live_imu.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

ImuSamples LiveSamples(const std::vector<int64_t>& times_ns) {
  ImuSamples samples;
  for (const int64_t time_ns : times_ns) samples.push_back({time_ns, {}, {}});
  return samples;
}

std::vector<int64_t> TakenBy(LiveImu& imu, int64_t until_ns) {
  std::vector<int64_t> times_ns;
  for (const ImuSample& sample : imu.Take(until_ns)) times_ns.push_back(sample.timestamp_ns);
  return times_ns;
}

TEST(LiveImuTest, EachSampleIsTakenOnceWithTheFrameThatIsTaken) {
  LiveImu imu;
  imu.Add(LiveSamples({5, 10, 15}));
  EXPECT_THAT(TakenBy(imu, 7), ElementsAre(5, 10));
  EXPECT_THAT(TakenBy(imu, 9), IsEmpty());
  // The frame came before its last sample did: it comes with the next one.
  EXPECT_THAT(TakenBy(imu, 20), ElementsAre(15));
  imu.Add(LiveSamples({20, 25}));
  imu.Add(LiveSamples({30}));
  EXPECT_THAT(TakenBy(imu, 30), ElementsAre(20, 25, 30));
  EXPECT_THAT(TakenBy(imu, 40), IsEmpty());
}

TEST(LiveImuTest, StampsAreMovedToTheCamerasClock) {
  LiveImu imu;
  imu.SetOffset(-3);
  imu.Add(LiveSamples({5, 10}));
  EXPECT_THAT(TakenBy(imu, 7), ElementsAre(2, 7));
}

TEST(LiveImuTest, AnotherClockForgetsTheOneBefore) {
  LiveImu imu;
  imu.Add(LiveSamples({1000, 1005}));
  imu.Add(LiveSamples({5, 10}));
  EXPECT_THAT(TakenBy(imu, 20), ElementsAre(5, 10));
  imu.Add(LiveSamples({1000}));
  EXPECT_THAT(TakenBy(imu, 1000), ElementsAre(1000));
  imu.Clear();
  imu.Add(LiveSamples({1}));
  EXPECT_THAT(TakenBy(imu, 1), ElementsAre(1));
}

TEST(LiveImuTest, TenSecondsAreKeptOfAFrameThatDoesNotCome) {
  LiveImu imu;
  for (int64_t i = 0; i < 3000; ++i) imu.Add(LiveSamples({i * 10'000'000}));
  const ImuSamples taken = imu.Take(29'990'000'000);
  EXPECT_GE(taken.size(), 900u);
  EXPECT_LE(taken.size(), 1001u);
  EXPECT_EQ(taken.back().timestamp_ns, 29'990'000'000);
}

}  // namespace
}  // namespace corbslam::client_agent
