#include "client_agent/upload/held_back.h"

#include "gtest/gtest.h"

namespace corbslam::client_agent {
namespace {

constexpr absl::Time kStart = absl::UnixEpoch();

absl::Time At(int seconds) { return kStart + absl::Seconds(seconds); }

int WaitedOf(const HeldBackWatch& watch, UpdateKind kind, int at_s) {
  return static_cast<int>(
      absl::ToInt64Seconds(watch.status(At(at_s)).waited[static_cast<size_t>(kind)]));
}

TEST(HeldBackTest, TheOldestIsTheFirstThatCame) {
  HeldBackWatch watch;
  watch.NoteWaiting({0, 2, 0, 0}, At(0));
  watch.NoteWaiting({0, 5, 0, 0}, At(10));
  EXPECT_EQ(WaitedOf(watch, UpdateKind::kKeyframes, 30), 30);
  EXPECT_EQ(WaitedOf(watch, UpdateKind::kPoints, 30), 0);
  watch.NoteTaken({0, 1, 0, 0});
  watch.NoteWaiting({0, 4, 0, 0}, At(31));
  EXPECT_EQ(WaitedOf(watch, UpdateKind::kKeyframes, 40), 40);
  watch.NoteTaken({0, 1, 0, 0});
  watch.NoteWaiting({0, 3, 0, 0}, At(41));
  EXPECT_EQ(WaitedOf(watch, UpdateKind::kKeyframes, 50), 40);
  watch.NoteTaken({0, 3, 0, 0});
  watch.NoteWaiting({}, At(51));
  EXPECT_EQ(WaitedOf(watch, UpdateKind::kKeyframes, 60), 0);
  EXPECT_TRUE(watch.status(At(60)).IsNothing());
}

TEST(HeldBackTest, WhatGoesUntoldIsNotWaitedFor) {
  HeldBackWatch watch;
  watch.NoteWaiting({0, 0, 0, 3}, At(0));
  watch.NoteWaiting({0, 0, 0, 1}, At(5));
  watch.NoteWaiting({0, 0, 0, 0}, At(6));
  EXPECT_EQ(WaitedOf(watch, UpdateKind::kLightPoints, 20), 0);
  watch.NoteWaiting({0, 0, 0, 2}, At(20));
  EXPECT_EQ(WaitedOf(watch, UpdateKind::kLightPoints, 25), 5);
}

TEST(HeldBackTest, AClockThatJumpsBackIsNoTime) {
  HeldBackWatch watch;
  watch.NoteWaiting({1, 0, 0, 0}, At(100));
  EXPECT_EQ(WaitedOf(watch, UpdateKind::kPoses, 50), 0);
}

TEST(HeldBackTest, IsSaidInWords) {
  EXPECT_EQ(ToString(UpdateCounts{0, 3, 120, 0}), "3 keyframes, 120 points");
  EXPECT_EQ(ToString(UpdateCounts{1, 0, 0, 7}), "1 poses, 7 light points");
  EXPECT_EQ(ToString(UpdateCounts{}), "nothing");
}

}  // namespace
}  // namespace corbslam::client_agent
