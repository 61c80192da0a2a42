#include "client_agent/agent/hand_over.h"

#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

constexpr HandOverLimits kLimits = {.max_map_bytes = 1000};

HandOverEvidence Full() { return {.map_bytes = 1100, .own_keyframes = 50}; }

TrackingResult Tracked(int matched, int in_view) {
  TrackingResult result;
  result.state = TrackingState::kTracking;
  result.points_matched = matched;
  result.points_in_view = in_view;
  return result;
}

HandOverVerdict Judge(const HandOverEvidence& evidence) {
  return JudgeHandOver(kLimits, evidence, Tracked(200, 300));
}

TEST(HandOverTest, AMapThatFitsGoesOn) {
  HandOverEvidence evidence = Full();
  EXPECT_EQ(Judge(evidence), HandOverVerdict::kNow);
  evidence.map_bytes = 1000;
  EXPECT_EQ(Judge(evidence), HandOverVerdict::kFits);
  evidence.map_bytes = uint64_t{1} << 40;
  EXPECT_EQ(JudgeHandOver(HandOverLimits(), evidence, Tracked(200, 300)), HandOverVerdict::kFits)
      << "no bound";
}

TEST(HandOverTest, AMapThatOthersFillIsNotLeftAtOnce) {
  HandOverEvidence evidence = Full();
  evidence.map_bytes = 5000;
  evidence.own_keyframes = 9;
  EXPECT_EQ(Judge(evidence), HandOverVerdict::kFits);
  evidence.own_keyframes = 10;
  EXPECT_EQ(Judge(evidence), HandOverVerdict::kNow);
}

TEST(HandOverTest, NothingIsGainedWhileTheLinkIsLate) {
  HandOverEvidence evidence = Full();
  evidence.map_bytes = 5000;
  evidence.earlier_map_waits = true;
  EXPECT_EQ(Judge(evidence), HandOverVerdict::kLinkIsLate);
  evidence.earlier_map_waits = false;
  evidence.outbox_has_room = false;
  EXPECT_EQ(Judge(evidence), HandOverVerdict::kLinkIsLate);
}

TEST(HandOverTest, WaitsForAGoodFrameButNotForEver) {
  HandOverEvidence evidence = Full();
  EXPECT_EQ(JudgeHandOver(kLimits, evidence, Tracked(59, 60)), HandOverVerdict::kMomentIsBad);
  EXPECT_EQ(JudgeHandOver(kLimits, evidence, Tracked(60, 201)), HandOverVerdict::kMomentIsBad);
  EXPECT_EQ(JudgeHandOver(kLimits, evidence, Tracked(60, 200)), HandOverVerdict::kNow);
  evidence.mapping_idle = false;
  EXPECT_EQ(Judge(evidence), HandOverVerdict::kMomentIsBad);
  evidence.map_bytes = 1201;
  EXPECT_EQ(Judge(evidence), HandOverVerdict::kNow);
  EXPECT_EQ(JudgeHandOver(kLimits, evidence, Tracked(10, 300)), HandOverVerdict::kNow);
  TrackingResult lost = Tracked(200, 300);
  lost.state = TrackingState::kLost;
  EXPECT_EQ(JudgeHandOver(kLimits, evidence, lost), HandOverVerdict::kMomentIsBad)
      << "a lost frame has no pose to go on from";
}

}  // namespace
}  // namespace corbslam::client_agent
