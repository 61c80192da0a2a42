#include "client_agent/live/rate_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

// Tells a watch of `seconds` at a rate, ten times a second; returns all that it said.
class Drive {
 public:
  explicit Drive(std::optional<double> expected_hz) : watch(expected_hz) {}
  std::string Go(double seconds, double rate_hz) {
    std::string said;
    for (int i = 0; i < static_cast<int>(10 * seconds); ++i) {
      now += absl::Milliseconds(100);
      frames += rate_hz / 10;
      if (const auto told = watch.Tell(now, static_cast<uint64_t>(frames)); told.has_value()) {
        said += *told + "\n";
      }
    }
    return said;
  }
  RateWatch watch;
  absl::Time now = absl::UnixEpoch();
  double frames = 0;
};

TEST(RateWatchTest, TellsThatTheRateFallsAndThatItIsBack) {
  Drive drive(std::nullopt);
  EXPECT_EQ(drive.Go(20, 30), "");
  EXPECT_NEAR(drive.watch.usual_interval_s().value_or(0), 1.0 / 30, 0.002);
  const std::string fell = drive.Go(20, 12);
  EXPECT_THAT(fell, HasSubstr("frames/s where"));
  EXPECT_EQ(std::count(fell.begin(), fell.end(), '\n'), 1) << "once, not each five seconds";
  EXPECT_THAT(drive.Go(12, 30), HasSubstr("again"));
}

TEST(RateWatchTest, TellsThatNothingComes) {
  Drive drive(20);
  EXPECT_EQ(drive.Go(6, 20), "");
  EXPECT_THAT(drive.Go(12, 0), HasSubstr("no frame for 5 s"));
  EXPECT_THAT(drive.Go(12, 20), HasSubstr("again"));
}

TEST(RateWatchTest, TheRigsRateIsWhatIsUsual) {
  Drive drive(30);
  EXPECT_THAT(drive.Go(12, 15), HasSubstr("where 30.0 are usual"));
}

TEST(RateWatchTest, KnowsNoIntervalBeforeTheFirstFrames) {
  RateWatch watch(std::nullopt);
  EXPECT_FALSE(watch.usual_interval_s().has_value());
}

}  // namespace
}  // namespace corbslam::client_agent
