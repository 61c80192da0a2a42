#include "services/ros2/silence_watch.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using std::chrono::seconds;

TEST(SilenceWatchTest, WhatHasGoneQuietIsNamed) {
  SilenceWatch watch(seconds(3));
  SilenceWatch::Moment now;
  FlowCounts counts;
  const auto run = [&](bool first, bool second, bool frames, bool poses) {
    Silence silence = Silence::kNone;
    for (int i = 0; i < 4; ++i) {
      counts.pictures[0] += first;
      counts.pictures[1] += second;
      counts.frames += frames;
      counts.poses += poses;
      silence = watch.Tell(counts, now);
      now += seconds(1);
    }
    return silence;
  };
  EXPECT_EQ(run(true, true, true, true), Silence::kNone);
  EXPECT_EQ(run(true, true, true, false), Silence::kNoPoses);
  EXPECT_GE(watch.silent_for(), seconds(3));
  EXPECT_EQ(run(true, true, false, false), Silence::kNoFrames);
  EXPECT_EQ(run(true, false, false, false), Silence::kSecondGone);
  EXPECT_EQ(run(false, true, false, false), Silence::kFirstGone);
  EXPECT_EQ(run(false, false, false, false), Silence::kNoPictures);
  EXPECT_EQ(run(true, true, true, true), Silence::kNone);
  EXPECT_EQ(watch.silent_for(), seconds(0));
}

TEST(SilenceWatchTest, ABeginningIsNoSilence) {
  SilenceWatch watch(seconds(3));
  SilenceWatch::Moment now;
  EXPECT_EQ(watch.Tell({}, now), Silence::kNone);
  EXPECT_EQ(watch.Tell({}, now + seconds(2)), Silence::kNone);
  EXPECT_EQ(watch.Tell({}, now + seconds(3)), Silence::kNoPictures);
}

}  // namespace
}  // namespace corbslam::services
