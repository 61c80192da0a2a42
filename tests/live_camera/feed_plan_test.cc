#include "tests/live_camera/feed_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::tests {
namespace {

using ::testing::HasSubstr;

// Times of frames at 10 Hz.
std::vector<double> TenASecond(size_t count) {
  std::vector<double> times_s;
  for (size_t i = 0; i < count; ++i) times_s.push_back(0.1 * static_cast<double>(i));
  return times_s;
}

TEST(FeedPlanTest, GivesEachFrameWhenItIsTaken) {
  const FeedPlan plan = MakeFeedPlan(TenASecond(30), {});
  ASSERT_EQ(plan.frames.size(), 30u);
  for (size_t i = 0; i < 30; ++i) {
    EXPECT_EQ(plan.frames[i].frame, i);
    EXPECT_DOUBLE_EQ(plan.frames[i].given_s, 0.1 * static_cast<double>(i));
    EXPECT_EQ(plan.frames[i].stamped_s, plan.frames[i].given_s);
  }
}

TEST(FeedPlanTest, DisturbsTheShareThatItIsAsked) {
  FeedOptions options;
  options.dropped = 0.1;
  options.late = 0.2;
  options.doubled = 0.05;
  const FeedPlan plan = MakeFeedPlan(TenASecond(2000), options);
  EXPECT_NEAR(static_cast<double>(plan.dropped), 200, 40);
  EXPECT_NEAR(static_cast<double>(plan.late), 400, 60);
  EXPECT_NEAR(static_cast<double>(plan.doubled), 100, 30);
  EXPECT_EQ(plan.frames.size(), 2000 - plan.dropped + plan.doubled);
  size_t late = 0;
  for (size_t i = 0; i < plan.frames.size(); ++i) {
    const FedFrame& frame = plan.frames[i];
    EXPECT_GE(frame.given_s, frame.stamped_s);
    EXPECT_LE(frame.given_s, frame.stamped_s + options.late_s);
    late += frame.given_s > frame.stamped_s ? 1 : 0;
    if (i > 0) {
      EXPECT_GE(frame.given_s, plan.frames[i - 1].given_s);
      EXPECT_GE(frame.stamped_s, plan.frames[i - 1].stamped_s);
    }
  }
  EXPECT_EQ(late, plan.late);
  EXPECT_EQ(Describe(MakeFeedPlan(TenASecond(2000), options)), Describe(plan)) << "the same seed";
  options.seed = 2;
  EXPECT_NE(Describe(MakeFeedPlan(TenASecond(2000), options)), Describe(plan));
}

TEST(FeedPlanTest, AnUnpluggedCameraGivesNothing) {
  FeedOptions options;
  options.unplug_at_s = 0.95;
  options.unplug_s = 1;
  const FeedPlan gone = MakeFeedPlan(TenASecond(30), options);
  ASSERT_EQ(gone.frames.size(), 20u);
  EXPECT_EQ(gone.unseen, 10u);
  EXPECT_EQ(gone.frames[10].frame, 20u);
  options.hold = true;
  const FeedPlan held = MakeFeedPlan(TenASecond(30), options);
  ASSERT_EQ(held.frames.size(), 30u);
  EXPECT_EQ(held.frames[10].frame, 10u);
  EXPECT_DOUBLE_EQ(held.frames[10].given_s, 2);
  EXPECT_DOUBLE_EQ(held.frames[10].stamped_s, 2);
}

TEST(FeedPlanTest, RefusesWhatNobodyCanDo) {
  FeedOptions options;
  options.dropped = 0.6;
  options.late = 0.6;
  EXPECT_THAT(std::string(Validate(options).message()),
              HasSubstr("dropped, late and doubled: 1.2, must be 0 to 1"));
  EXPECT_TRUE(Validate(FeedOptions()).ok());
}

}  // namespace
}  // namespace corbslam::tests
