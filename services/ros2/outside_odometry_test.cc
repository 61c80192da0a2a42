#include "services/ros2/outside_odometry.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

constexpr int64_t kMs = 1'000'000;

Rigid3d Along(double x) { return {Eigen::Quaterniond::Identity(), {x, 0, 0}}; }

TEST(OutsideOdometryTest, AFrameWaitsForTheOdometryAroundIt) {
  OutsideOdometry odometry;
  EXPECT_TRUE(odometry.AddOdom(1000 * kMs, Along(1)).empty());
  EXPECT_TRUE(odometry.AddMap(1050 * kMs, Along(10)).empty());
  const auto matched = odometry.AddOdom(1100 * kMs, Along(2));
  ASSERT_EQ(matched.size(), 1u);
  EXPECT_EQ(matched[0].timestamp_ns, 1050 * kMs);
  EXPECT_NEAR(matched[0].motion.translation.x(), 10 - 1.5, 1e-12);
  // A frame that is late finds what is kept.
  const auto late = odometry.AddMap(1100 * kMs, Along(11));
  ASSERT_EQ(late.size(), 1u);
  EXPECT_NEAR(late[0].motion.translation.x(), 9, 1e-12);
  EXPECT_EQ(odometry.unmatched(), 0u);
}

TEST(OutsideOdometryTest, NothingIsExtrapolated) {
  OutsideOdometry odometry;
  EXPECT_TRUE(odometry.AddMap(900 * kMs, Along(10)).empty());
  EXPECT_TRUE(odometry.AddOdom(1000 * kMs, Along(1)).empty());  // Nothing was before the frame.
  EXPECT_EQ(odometry.unmatched(), 1u);
  EXPECT_TRUE(odometry.AddMap(1300 * kMs, Along(10)).empty());
  EXPECT_TRUE(odometry.AddOdom(1600 * kMs, Along(2)).empty());  // A gap.
  EXPECT_EQ(odometry.unmatched(), 2u);
}

TEST(OutsideOdometryTest, OdometryThatNeverComesIsCounted) {
  OutsideOdometry odometry;
  for (int i = 0; i < 30; ++i) odometry.AddMap(1000 * kMs + i * 100 * kMs, Along(1));
  EXPECT_EQ(odometry.unmatched(), 9u);  // Those that have waited for more than 2 s.
}

TEST(OutsideOdometryTest, AnotherClockBeginsAnew) {
  OutsideOdometry odometry;
  odometry.AddOdom(1000 * kMs, Along(1));
  odometry.AddOdom(10 * kMs, Along(2));
  odometry.AddMap(15 * kMs, Along(5));
  const auto matched = odometry.AddOdom(20 * kMs, Along(3));
  ASSERT_EQ(matched.size(), 1u);
  EXPECT_NEAR(matched[0].motion.translation.x(), 2.5, 1e-12);
}

}  // namespace
}  // namespace corbslam::services
