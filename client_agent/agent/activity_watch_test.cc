#include "client_agent/agent/activity_watch.h"

#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class ActivityWatchTest : public ::testing::Test {
 protected:
  void Frame(TrackingState state, uint64_t dropped = 0) {
    TrackingResult result;
    result.timestamp_ns = ++time_ns_;
    result.state = state;
    watch_.NoteFrame(result, now_, dropped);
  }
  AgentActivity Activity() const { return watch_.Report().activity; }

  int64_t time_ns_ = 0;
  ActivityWatch::Moment now_{seconds(1000)};
  ActivityWatch watch_{[this] { return now_; }};
};

TEST_F(ActivityWatchTest, SaysWhatBecomesOfFrames) {
  EXPECT_EQ(Activity(), AgentActivity::kInitialising);
  Frame(TrackingState::kNotInitialised);
  EXPECT_EQ(Activity(), AgentActivity::kInitialising);
  Frame(TrackingState::kTracking);
  EXPECT_EQ(Activity(), AgentActivity::kTracking);
  Frame(TrackingState::kLost, 3);
  const AgentReport report = watch_.Report();
  EXPECT_EQ(report, (AgentReport{.activity = AgentActivity::kLost,
                                 .frames = 3,
                                 .tracked = 1,
                                 .lost = 1,
                                 .dropped = 3,
                                 .newest_timestamp_ns = 3}));
}

TEST_F(ActivityWatchTest, ARobotWithoutFramesWaits) {
  now_ += seconds(3);
  EXPECT_EQ(Activity(), AgentActivity::kWaiting) << "none came at all";
  Frame(TrackingState::kTracking);
  now_ += seconds(2);
  EXPECT_EQ(Activity(), AgentActivity::kTracking);
  now_ += milliseconds(500);
  EXPECT_EQ(Activity(), AgentActivity::kWaiting);
  EXPECT_DOUBLE_EQ(watch_.Report().newest_frame_age_s, 2.5);
  Frame(TrackingState::kTracking);
  EXPECT_EQ(Activity(), AgentActivity::kTracking);
}

TEST_F(ActivityWatchTest, WhatHasEndedStaysSo) {
  Frame(TrackingState::kTracking);
  watch_.NoteEnd();
  EXPECT_EQ(Activity(), AgentActivity::kFinished);
  now_ += seconds(100);
  EXPECT_EQ(Activity(), AgentActivity::kFinished);
  EXPECT_DOUBLE_EQ(watch_.Report().newest_frame_age_s, 100);
}

// A recorded sequence's times may be anything.
TEST_F(ActivityWatchTest, TimesStayWithinWhatAReportMayHave) {
  TrackingResult result;
  result.timestamp_ns = -5;
  watch_.NoteFrame(result, now_, 0);
  EXPECT_EQ(watch_.Report().newest_timestamp_ns, 0);
}

}  // namespace
}  // namespace corbslam::client_agent
