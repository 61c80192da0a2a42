#include "services/tool/replay/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

namespace corbslam::services {

using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

using ::testing::HasSubstr;

TrackingResult Tracked(uint64_t local_map, double x_m) {
  TrackingResult result;
  result.state = TrackingState::kTracking;
  result.local_map = {local_map};
  result.camera_from_local.translation.x() = x_m;
  return result;
}

TrackingResult Lost(uint64_t local_map) {
  TrackingResult result;
  result.state = TrackingState::kLost;
  result.local_map = {local_map};
  return result;
}

TEST(ComparisonTest, EqualRunsAreEqualToTheDigit) {
  const FrameResults run = {Tracked(7, 0), Tracked(7, 0.1), Lost(7), Tracked(8, 0)};
  const ReplayComparison comparison = CompareResults(run, run);
  EXPECT_TRUE(comparison.AllEqual());
  EXPECT_EQ(comparison.compared, 4u);
  EXPECT_FALSE(comparison.first_pose.has_value());
  EXPECT_EQ(comparison.recorded_events,
            (std::vector<TrackingEvent>{{0, "tracking in local map 1"},
                                        {2, "lost in local map 1"},
                                        {3, "tracking in local map 2"}}));
  EXPECT_THAT(FormatComparison(comparison), HasSubstr("replayed: the same"));
}

TEST(ComparisonTest, TheLastDigitCounts) {
  const FrameResults recorded = {Tracked(7, 0), Tracked(7, 0.1), Tracked(7, 0.2)};
  FrameResults replayed = recorded;
  replayed[1]->camera_from_local.translation.x() = std::nextafter(0.1, 1);
  const ReplayComparison comparison = CompareResults(recorded, replayed);
  EXPECT_EQ(comparison.equal, 2u);
  EXPECT_EQ(comparison.first_different, 1u);
  ASSERT_TRUE(comparison.first_pose.has_value());
  EXPECT_GT(comparison.first_pose->position_m, 0);
  EXPECT_LT(comparison.first_pose->position_m, 1e-15);
  EXPECT_NE(DigestOf(recorded), DigestOf(replayed));
}

TEST(ComparisonTest, SaysByHowMuchPosesDifferAtMost) {
  const FrameResults recorded = {Tracked(7, 0), Tracked(7, 1), Tracked(7, 2)};
  const FrameResults replayed = {Tracked(7, 0), Tracked(7, 1.25), Tracked(7, 2.5)};
  const ReplayComparison comparison = CompareResults(recorded, replayed);
  ASSERT_TRUE(comparison.largest_pose.has_value());
  EXPECT_EQ(comparison.first_pose->frame, 1u);
  EXPECT_DOUBLE_EQ(comparison.first_pose->position_m, 0.25);
  EXPECT_EQ(comparison.largest_pose->frame, 2u);
  EXPECT_DOUBLE_EQ(comparison.largest_pose->position_m, 0.5);
}

TEST(ComparisonTest, PosesInMapsThatBeganAtOtherFramesAreNotCompared) {
  const FrameResults recorded = {Tracked(7, 0), Lost(7), Tracked(8, 0), Tracked(8, 1)};
  const FrameResults replayed = {Tracked(7, 0), Lost(7), Lost(7), Tracked(9, 0)};
  const ReplayComparison comparison = CompareResults(recorded, replayed);
  EXPECT_EQ(comparison.equal, 2u);
  EXPECT_EQ(comparison.first_different, 2u);
  EXPECT_FALSE(comparison.first_pose.has_value());
  EXPECT_THAT(FormatComparison(comparison),
              HasSubstr("replayed: frame 0 tracking in local map 1, frame 1 lost in local map 1, "
                        "frame 3 tracking in local map 2"));
}

TEST(ComparisonTest, FramesWithoutAResultAreNotCompared) {
  const ReplayComparison comparison =
      CompareResults({Tracked(7, 0), std::nullopt}, {Tracked(7, 0), Tracked(7, 1)});
  EXPECT_EQ(comparison.compared, 1u);
  EXPECT_TRUE(comparison.AllEqual());
}

TEST(ComparisonTest, TheDigestIsOfWhatIsValid) {
  FrameResults other = {Lost(7)};
  other[0]->camera_from_local.translation.x() = 5;
  EXPECT_EQ(DigestOf({Lost(7)}), DigestOf(other));
  EXPECT_NE(DigestOf({Lost(7)}), DigestOf({Tracked(7, 0)}));
}

}  // namespace
}  // namespace corbslam::services
