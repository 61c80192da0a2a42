#include "client_agent/tracking/keyframe_policy.h"

#include <gtest/gtest.h>

namespace corbslam::client_agent {
namespace {

// A frame that sees most of what its reference sees.
KeyframeEvidence Content() {
  return {.inliers = 200,
          .reference_points = 220,
          .map_keyframes = 10,
          .close_tracked = 150,
          .close_untracked = 50,
          .since_last_keyframe_s = 0.2,
          .mapper_idle = true,
          .queue_has_room = true};
}

TEST(KeyframePolicyTest, AFrameThatShowsNothingNewIsNotKept) {
  EXPECT_FALSE(ShouldMakeKeyframe(Content()));
  KeyframeEvidence later = Content();
  later.since_last_keyframe_s = 100;
  EXPECT_FALSE(ShouldMakeKeyframe(later));
}

TEST(KeyframePolicyTest, AFrameThatLostAQuarterOfItsReferenceIsKept) {
  KeyframeEvidence evidence = Content();
  evidence.inliers = 160;
  EXPECT_TRUE(ShouldMakeKeyframe(evidence));
}

TEST(KeyframePolicyTest, LittleThatIsNewIsKeptWhenNothingWasForAWhile) {
  KeyframeEvidence evidence = Content();
  evidence.inliers = 180;
  EXPECT_FALSE(ShouldMakeKeyframe(evidence));
  evidence.since_last_keyframe_s = 0.45;
  EXPECT_TRUE(ShouldMakeKeyframe(evidence));
  evidence.inliers = 200;
  EXPECT_FALSE(ShouldMakeKeyframe(evidence));
}

TEST(KeyframePolicyTest, AFrameThatOthersKeepTrackedIsKeptBeforeItLosesItsReference) {
  KeyframeEvidence evidence = Content();
  evidence.share_of_reference = 0.6;
  EXPECT_FALSE(ShouldMakeKeyframe(evidence));
  evidence.share_of_reference = 0.4;
  EXPECT_TRUE(ShouldMakeKeyframe(evidence));
}

TEST(KeyframePolicyTest, FewClosePointsThoughManyCouldBeMadeCallForOne) {
  KeyframeEvidence evidence = Content();
  evidence.close_tracked = 80;
  EXPECT_FALSE(ShouldMakeKeyframe(evidence));
  evidence.close_untracked = 90;
  EXPECT_TRUE(ShouldMakeKeyframe(evidence));
  evidence.mapper_idle = false;
  EXPECT_TRUE(ShouldMakeKeyframe(evidence));
}

TEST(KeyframePolicyTest, ABusyMapperIsSparedUnlessItIsUrgentOrLongAgo) {
  KeyframeEvidence evidence = Content();
  evidence.inliers = 160;
  evidence.mapper_idle = false;
  EXPECT_FALSE(ShouldMakeKeyframe(evidence));
  evidence.since_last_keyframe_s = 1.5;
  EXPECT_TRUE(ShouldMakeKeyframe(evidence));
  evidence.since_last_keyframe_s = 0.1;
  evidence.inliers = 50;
  EXPECT_TRUE(ShouldMakeKeyframe(evidence));
}

TEST(KeyframePolicyTest, AFullQueueOrALostFrameMakesNone) {
  KeyframeEvidence evidence = Content();
  evidence.inliers = 160;
  evidence.queue_has_room = false;
  EXPECT_FALSE(ShouldMakeKeyframe(evidence));
  evidence.queue_has_room = true;
  evidence.inliers = 12;
  EXPECT_FALSE(ShouldMakeKeyframe(evidence));
}

TEST(KeyframePolicyTest, AtTheStartMoreMustBeLost) {
  KeyframeEvidence evidence = Content();
  evidence.map_keyframes = 1;
  evidence.inliers = 150;
  EXPECT_FALSE(ShouldMakeKeyframe(evidence));
  evidence.inliers = 80;
  EXPECT_TRUE(ShouldMakeKeyframe(evidence));
}

}  // namespace
}  // namespace corbslam::client_agent
