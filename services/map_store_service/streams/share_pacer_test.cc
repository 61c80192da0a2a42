#include "services/map_store_service/streams/share_pacer.h"

#include "gtest/gtest.h"

namespace corbslam::services {
namespace {

constexpr absl::Time kStart = absl::UnixEpoch();

TEST(SharePacerTest, WithoutABoundNothingWaits) {
  SharePacer pacer;
  EXPECT_EQ(pacer.NoteSent(1 << 30, kStart), absl::ZeroDuration());
  EXPECT_EQ(pacer.Wait(kStart), absl::ZeroDuration());
  EXPECT_EQ(pacer.Allow(1000000, kStart), 1000000u);
}

TEST(SharePacerTest, WhatWasSentIsPaidForFirst) {
  SharePacer pacer(10000);
  EXPECT_EQ(pacer.Wait(kStart), absl::ZeroDuration());
  EXPECT_EQ(pacer.Allow(1000000, kStart), 10000u);
  EXPECT_EQ(pacer.NoteSent(40000, kStart), absl::ZeroDuration());
  const absl::Duration wait = pacer.Wait(kStart + absl::Seconds(1));
  EXPECT_GE(wait, absl::Seconds(2));
  EXPECT_LT(wait, absl::Seconds(2.1));
  const absl::Time then = kStart + absl::Seconds(1) + wait;
  EXPECT_EQ(pacer.Wait(then), absl::ZeroDuration());
  EXPECT_EQ(pacer.NoteSent(500, then), wait);
  EXPECT_EQ(pacer.NoteSent(0, then), absl::ZeroDuration());
}

TEST(SharePacerTest, NeverMoreThanTheStoreWouldSendNorSoLittleThatItIsAllFrame) {
  SharePacer pacer(10000);
  EXPECT_EQ(pacer.Allow(700, kStart), 700u);
  pacer.NoteSent(9999, kStart);
  EXPECT_EQ(pacer.Allow(1000000, kStart), 2048u);
  SharePacer fast(uint64_t{1} << 40);
  EXPECT_EQ(fast.Allow(128 << 10, kStart), 128u << 10);
}

}  // namespace
}  // namespace corbslam::services
