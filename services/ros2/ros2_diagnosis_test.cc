#include "services/ros2/ros2_diagnosis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using client_agent::TrackingState;
using client_agent::WhyNoPose;
using ::testing::HasSubstr;
using Level = Ros2Diagnosis::Level;

Ros2Facts Tracking() {
  Ros2Facts facts;
  facts.has_begun = true;
  facts.image_topics[0] = "/left";
  facts.image_topics[1] = "/right";
  facts.agent.state = TrackingState::kTracking;
  facts.agent.frames = 1;
  return facts;
}

TEST(Ros2DiagnosisTest, AllIsWell) {
  for (const Ros2Diagnosis& line : Diagnose(Tracking())) {
    EXPECT_EQ(line.level, Level::kOk) << line.message;
  }
  EXPECT_EQ(Diagnose(Tracking()).size(), 3u);  // No line of a store that is not wanted.
}

TEST(Ros2DiagnosisTest, WhatIsWrongIsSaid) {
  Ros2Facts facts = Tracking();
  facts.agent.state = TrackingState::kLost;
  facts.agent.why_no_pose = WhyNoPose::kFewKeypoints;
  EXPECT_EQ(Diagnose(facts)[0].level, Level::kWarning);
  EXPECT_THAT(Diagnose(facts)[0].message, HasSubstr("FEW_KEYPOINTS"));
  facts.silence = Silence::kSecondGone;
  facts.silent_for_s = 4;
  EXPECT_EQ(Diagnose(facts)[0].level, Level::kError);
  EXPECT_THAT(Diagnose(facts)[0].message,
              HasSubstr("no picture of /right came for 4.0 s, though those of /left do"));
  facts.stamp_ahead_s = -3600;
  EXPECT_THAT(Diagnose(facts)[1].message, HasSubstr("use_sim_time:=true"));
  facts.conflicts = {"odom -> base_link"};
  EXPECT_EQ(Diagnose(facts)[2].level, Level::kError);
  EXPECT_THAT(Diagnose(facts)[2].message, HasSubstr("odom -> base_link, too"));
  facts.conflicts.clear();
  facts.unmatched = 7;
  EXPECT_THAT(Diagnose(facts)[2].message, HasSubstr("missing for 7 frames"));
  facts.unmatched = 0;
  facts.agent.local_maps = 2;
  EXPECT_THAT(Diagnose(facts)[2].message, HasSubstr("another one than before"));
  facts.session = absl::UnavailableError("connection refused");
  EXPECT_EQ(Diagnose(facts)[3].message, "connection refused");
}

TEST(Ros2DiagnosisTest, BeforeTheCameraIsThere) {
  Ros2Facts facts;
  facts.waits_for = "nobody publishes /left";
  EXPECT_EQ(Diagnose(facts)[0].level, Level::kStale);
  EXPECT_EQ(Diagnose(facts)[1].level, Level::kError);
  EXPECT_EQ(Diagnose(facts)[1].message, "nobody publishes /left");
}

}  // namespace
}  // namespace corbslam::services
