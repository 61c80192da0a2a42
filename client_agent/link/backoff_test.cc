#include "client_agent/link/backoff.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace corbslam::client_agent {
namespace {

TEST(BackoffTest, WaitsTwiceAsLongUpToTheMostAndShortAfterASuccess) {
  constexpr absl::Duration kLeast = absl::Seconds(10);
  constexpr absl::Duration kMost = absl::Seconds(80);
  Backoff backoff(kLeast, kMost, /*seed=*/1);
  for (int round = 0; round < 2; ++round) {
    absl::Duration longest = kLeast;
    for (int attempt = 0; attempt < 20; ++attempt) {
      const absl::Duration wait = backoff.Next();
      EXPECT_GE(wait, longest / 2) << attempt;
      EXPECT_LE(wait, longest) << attempt;
      longest = std::min(2 * longest, kMost);
    }
    backoff.Reset();
  }
}

TEST(BackoffTest, TwoRobotsDoNotComeAtOnce) {
  Backoff first(absl::Seconds(1), absl::Seconds(1), 1);
  Backoff second(absl::Seconds(1), absl::Seconds(1), 2);
  EXPECT_NE(first.Next(), second.Next());
}

}  // namespace
}  // namespace corbslam::client_agent
