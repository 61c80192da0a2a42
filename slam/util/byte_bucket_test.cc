#include "slam/util/byte_bucket.h"

#include <limits>

#include "gtest/gtest.h"

namespace corbslam {
namespace {

constexpr absl::Time kStart = absl::UnixEpoch();

TEST(ByteBucketTest, HoldsNoMoreThanItsDepth) {
  ByteBucket bucket(1000, absl::Seconds(2));
  EXPECT_EQ(bucket.Level(kStart), 2000);
  bucket.Spend(1500, kStart);
  EXPECT_EQ(bucket.Level(kStart), 500);
  EXPECT_EQ(bucket.Level(kStart + absl::Seconds(1)), 1500);
  EXPECT_EQ(bucket.Level(kStart + absl::Hours(1)), 2000);
}

TEST(ByteBucketTest, ADebtIsPaidBeforeAnythingIsSpent) {
  ByteBucket bucket(1000);
  bucket.Spend(4000, kStart);
  EXPECT_EQ(bucket.Level(kStart), -3000);
  const absl::Duration wait = bucket.Wait(kStart);
  EXPECT_LE(bucket.Level(kStart + absl::Seconds(3)), 0);
  EXPECT_GT(bucket.Level(kStart + wait), 0);
  EXPECT_LT(wait, absl::Seconds(3.1));
  EXPECT_EQ(bucket.Wait(kStart + absl::Seconds(4)), absl::ZeroDuration());
}

TEST(ByteBucketTest, LumpsOfAnyLengthKeepTheMean) {
  for (const int64_t lump : {10, 999, 50000}) {
    ByteBucket bucket(1000);
    int64_t spent = 0;
    absl::Time now = kStart;
    for (; now < kStart + absl::Minutes(10); now += absl::Milliseconds(7)) {
      if (bucket.Level(now) <= 0) continue;
      bucket.Spend(lump, now);
      spent += lump;
    }
    const double most = 1000 * (1 + absl::ToDoubleSeconds(now - kStart));
    EXPECT_LE(static_cast<double>(spent), most + static_cast<double>(lump));
    EXPECT_GE(static_cast<double>(spent), most - 1000 - static_cast<double>(lump));
  }
}

TEST(ByteBucketTest, WhatNeverLeftComesBack) {
  ByteBucket bucket(1000);
  bucket.Spend(700, kStart);
  bucket.Spend(-300, kStart);
  EXPECT_EQ(bucket.Level(kStart), 600);
  bucket.Spend(-5000, kStart);
  EXPECT_EQ(bucket.Level(kStart), 1000);
}

TEST(ByteBucketTest, AClockThatJumpsFillsNoMoreThanTheDepthAndNothingBackwards) {
  ByteBucket bucket(1000);
  bucket.Spend(1000, kStart);
  EXPECT_EQ(bucket.Level(kStart - absl::Hours(1)), 0);
  EXPECT_EQ(bucket.Level(kStart - absl::Hours(1) + absl::Milliseconds(500)), 500);
  EXPECT_EQ(bucket.Level(kStart + absl::Hours(24 * 365)), 1000);
}

TEST(ByteBucketTest, ASlowOneIsNeverStuck) {
  ByteBucket bucket(1, absl::Milliseconds(1));
  EXPECT_GT(bucket.Level(kStart), 0);
  bucket.Spend(1, kStart);
  EXPECT_GT(bucket.Level(kStart + bucket.Wait(kStart)), 0);
}

TEST(ByteBucketTest, WithoutABoundAnythingGoes) {
  ByteBucket bucket(0);
  EXPECT_FALSE(bucket.is_bounded());
  bucket.Spend(int64_t{1} << 60, kStart);
  EXPECT_EQ(bucket.Level(kStart), std::numeric_limits<int64_t>::max());
  EXPECT_EQ(bucket.Wait(kStart), absl::ZeroDuration());
}

}  // namespace
}  // namespace corbslam
