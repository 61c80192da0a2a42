#include "client_agent/source/kept_imu.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

ImuSamples KeptSamplesAt(const std::vector<int64_t>& times_ns) {
  ImuSamples samples;
  for (const int64_t time_ns : times_ns) samples.push_back({time_ns, {}, {}});
  return samples;
}

std::vector<int64_t> TimesOfKept(const ImuSamples& samples) {
  std::vector<int64_t> times_ns;
  for (const ImuSample& sample : samples) times_ns.push_back(sample.timestamp_ns);
  return times_ns;
}

TEST(KeptImuTest, GivesWhatWasKeptOnceBeforeTheNext) {
  KeptImu kept;
  kept.Keep(0, KeptSamplesAt({1, 2}));
  kept.Keep(0, {});
  kept.Keep(0, KeptSamplesAt({3}));
  ImuSamples next = KeptSamplesAt({4});
  kept.GiveTo(0, next);
  EXPECT_THAT(TimesOfKept(next), ElementsAre(1, 2, 3, 4));
  next = KeptSamplesAt({5});
  kept.GiveTo(0, next);
  EXPECT_THAT(TimesOfKept(next), ElementsAre(5));
  kept.Keep(0, KeptSamplesAt({6}));
  next.clear();
  kept.GiveTo(0, next);
  EXPECT_THAT(TimesOfKept(next), ElementsAre(6));
}

TEST(KeptImuTest, AnotherDriveHasNothingOfIt) {
  KeptImu kept;
  kept.Keep(0, KeptSamplesAt({10}));
  ImuSamples next;
  kept.GiveTo(1, next);
  EXPECT_THAT(TimesOfKept(next), IsEmpty());
  kept.Keep(1, KeptSamplesAt({1}));
  kept.GiveTo(1, next);
  EXPECT_THAT(TimesOfKept(next), ElementsAre(1));
}

TEST(KeptImuTest, ForgetsWhatIsOlderThanAnybodyBridges) {
  KeptImu kept;
  for (int64_t i = 0; i < 100; ++i) kept.Keep(0, KeptSamplesAt({i * 1'000'000'000}));
  ImuSamples next = KeptSamplesAt({100'000'000'000});
  kept.GiveTo(0, next);
  EXPECT_EQ(next.size(), 11u);
  EXPECT_EQ(next.front().timestamp_ns, 90'000'000'000);
}

}  // namespace
}  // namespace corbslam::client_agent
