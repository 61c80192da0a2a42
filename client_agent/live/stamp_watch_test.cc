#include "client_agent/live/stamp_watch.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace corbslam::client_agent {
namespace {

using Verdict = StampWatch::Verdict;

constexpr int64_t kSecond_ns = 1'000'000'000;
constexpr int64_t kYears_ns = int64_t{1'700'000'000} * kSecond_ns;

class StampWatchTest : public ::testing::Test {
 protected:
  // A picture comes each second.
  Verdict Judge(int64_t stamp_ns) {
    now_ += std::chrono::seconds(1);
    return watch_.Judge(stamp_ns, now_);
  }

  StampWatch watch_;
  StampWatch::Moment now_;
};

TEST_F(StampWatchTest, OneStampOfAnotherClockIsLeftOut) {
  for (const int64_t astray_ns : {kYears_ns, int64_t{0}, 30 * kSecond_ns}) {
    watch_.Reset();
    EXPECT_EQ(Judge(100 * kSecond_ns), Verdict::kTake);
    EXPECT_EQ(Judge(astray_ns), astray_ns > 100 * kSecond_ns ? Verdict::kAhead : Verdict::kLate);
    EXPECT_EQ(Judge(102 * kSecond_ns), Verdict::kTake);
  }
}

TEST_F(StampWatchTest, AClockThatStaysIsTheCamerasFromThenOn) {
  for (const int64_t begin_ns : {kYears_ns, int64_t{0}}) {
    watch_.Reset();
    EXPECT_EQ(Judge(100 * kSecond_ns), Verdict::kTake);
    for (int i = 1; i < StampWatch::kBeginAnew; ++i) {
      EXPECT_NE(Judge(begin_ns + i * kSecond_ns), Verdict::kAnew);
    }
    EXPECT_EQ(Judge(begin_ns + 10 * kSecond_ns), Verdict::kAnew);
    EXPECT_EQ(Judge(begin_ns + 11 * kSecond_ns), Verdict::kTake);
  }
}

// A first picture that is wrong costs a few, and not all that follow.
TEST_F(StampWatchTest, AWrongFirstStampIsOvercome) {
  EXPECT_EQ(Judge(kYears_ns), Verdict::kTake);
  int left_out = 0;
  for (int i = 1; Judge(i * kSecond_ns) != Verdict::kAnew; ++i) ASSERT_LT(++left_out, 10);
  EXPECT_EQ(left_out, StampWatch::kBeginAnew - 1);
}

TEST_F(StampWatchTest, LateOnesAmongGoodOnesBeginNothing) {
  EXPECT_EQ(Judge(100 * kSecond_ns), Verdict::kTake);
  for (int i = 1; i < 50; ++i) {
    EXPECT_EQ(Judge((100 + i) * kSecond_ns), Verdict::kTake);
    EXPECT_EQ(Judge((99 + i) * kSecond_ns), Verdict::kLate);
  }
  // A clock that stands is none.
  for (int i = 0; i < 50; ++i) EXPECT_EQ(Judge(7), Verdict::kLate);
}

TEST_F(StampWatchTest, ACameraMayBeAwayForLong) {
  EXPECT_EQ(Judge(100 * kSecond_ns), Verdict::kTake);
  now_ += std::chrono::hours(3);
  EXPECT_EQ(Judge((102 + 3 * 3600) * kSecond_ns), Verdict::kTake);
  // Its driver may count more slowly, or not while it is away.
  now_ += std::chrono::hours(3);
  EXPECT_EQ(Judge((103 + 3 * 3600) * kSecond_ns), Verdict::kTake);
}

TEST_F(StampWatchTest, StampsOfAnySizeAreCompared) {
  EXPECT_EQ(Judge(std::numeric_limits<int64_t>::min()), Verdict::kTake);
  EXPECT_EQ(Judge(std::numeric_limits<int64_t>::max()), Verdict::kAhead);
}

}  // namespace
}  // namespace corbslam::client_agent
