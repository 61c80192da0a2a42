#include "client_agent/agent/agent_orders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

TEST(AgentOrdersTest, EachOrderIsTakenOnceAndThePauseStays) {
  AgentOrders orders;
  orders.SetCamera({.width_px = 64, .height_px = 48});
  EXPECT_FALSE(orders.Take().open_local_map);
  ASSERT_TRUE(orders.OpenLocalMap().ok());
  ASSERT_TRUE(orders.SetMask(cv::Mat::zeros(48, 64, CV_8UC1)).ok());

  const OrdersForFrame first = orders.Take();
  EXPECT_TRUE(first.open_local_map);
  EXPECT_FALSE(first.mapping_paused);
  ASSERT_TRUE(first.mask.has_value());
  EXPECT_EQ(first.mask->cols, 64);

  orders.NoteTracked();
  ASSERT_TRUE(orders.PauseMapping(true).ok());
  const OrdersForFrame second = orders.Take();
  EXPECT_FALSE(second.open_local_map);
  EXPECT_FALSE(second.mask.has_value());
  EXPECT_TRUE(second.mapping_paused);
  EXPECT_TRUE(orders.Take().mapping_paused);
  ASSERT_TRUE(orders.PauseMapping(false).ok());
  EXPECT_FALSE(orders.Take().mapping_paused);
}

TEST(AgentOrdersTest, LimitsAreTakenOnce) {
  AgentOrders orders;
  orders.SetLimits({.uplink_bytes_per_second = 5});
  orders.SetLimits({.uplink_bytes_per_second = 7, .share = ShareScope{ShareMode::kNone}});
  const ChangedLimits limits = orders.Take().limits;
  EXPECT_EQ(limits.uplink_bytes_per_second, 7u);
  EXPECT_FALSE(limits.max_map_bytes.has_value());
  EXPECT_EQ(limits.share->mode, ShareMode::kNone);
  EXPECT_FALSE(orders.Take().limits.uplink_bytes_per_second.has_value());
}

TEST(AgentOrdersTest, MappingIsNotPausedInAMapThatIsEmpty) {
  AgentOrders orders;
  ASSERT_TRUE(orders.OpenLocalMap().ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(orders.PauseMapping(true))) << "before a frame";
  // A frame that was on its way when the order came is of the map before.
  orders.NoteTracked();
  EXPECT_TRUE(absl::IsFailedPrecondition(orders.PauseMapping(true)));
  EXPECT_TRUE(orders.Take().open_local_map);
  EXPECT_TRUE(absl::IsFailedPrecondition(orders.PauseMapping(true))) << "nothing is tracked yet";
  EXPECT_TRUE(orders.PauseMapping(false).ok());
  EXPECT_FALSE(orders.Take().mapping_paused);
  orders.NoteTracked();
  EXPECT_TRUE(orders.PauseMapping(true).ok());
  EXPECT_TRUE(orders.Take().mapping_paused);
}

TEST(AgentOrdersTest, TheListenerHearsWhatIsNew) {
  AgentOrders orders;
  orders.SetCamera({.width_px = 64, .height_px = 48});
  std::vector<OrdersForFrame> heard;
  orders.SetListener([&](const OrdersForFrame& taken) { heard.push_back(taken); });
  orders.Take();
  EXPECT_TRUE(heard.empty());
  ASSERT_TRUE(orders.PauseMapping(true).ok());
  orders.Take();
  orders.Take();
  ASSERT_EQ(heard.size(), 1u);
  EXPECT_TRUE(heard[0].mapping_paused);
  ASSERT_TRUE(orders.PauseMapping(false).ok());
  ASSERT_TRUE(orders.OpenLocalMap().ok());
  ASSERT_TRUE(orders.SetMask(cv::Mat()).ok());
  orders.Take();
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_TRUE(!heard[1].mapping_paused && heard[1].open_local_map && heard[1].mask.has_value());
}

TEST(AgentOrdersTest, NoMapOpensWhileMappingIsPaused) {
  AgentOrders orders;
  ASSERT_TRUE(orders.PauseMapping(true).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(orders.OpenLocalMap()));
  EXPECT_FALSE(orders.Take().open_local_map);
}

TEST(AgentOrdersTest, AMaskMustHaveThePicturesSizeAndOnlyGreys) {
  AgentOrders orders;
  orders.SetCamera({.width_px = 64, .height_px = 48});
  EXPECT_THAT(std::string(orders.SetMask(cv::Mat::zeros(64, 48, CV_8UC1)).message()),
              HasSubstr("48x64"));
  EXPECT_TRUE(absl::IsInvalidArgument(orders.SetMask(cv::Mat::zeros(48, 64, CV_8UC3))));
  EXPECT_FALSE(orders.Take().mask.has_value());
  // Of pictures that are scaled the mask is that of the recorded ones, as a rig's is.
  orders.SetRecordedSize(128, 97);
  cv::Mat recorded(97, 128, CV_8UC1, cv::Scalar(255));
  recorded.colRange(0, 32) = cv::Scalar(0);
  ASSERT_TRUE(orders.SetMask(recorded).ok());
  const cv::Mat scaled = *orders.Take().mask;
  EXPECT_EQ(scaled.size(), cv::Size(64, 48));
  EXPECT_EQ(cv::countNonZero(scaled), 48 * 48);
  EXPECT_EQ(cv::countNonZero(scaled == 255), 48 * 48);
  EXPECT_TRUE(orders.SetMask(scaled).ok());
  EXPECT_EQ(orders.Take().mask->cols, 64);
  EXPECT_THAT(std::string(orders.SetMask(cv::Mat::zeros(96, 128, CV_8UC1)).message()),
              HasSubstr("expected 128x97"));
  // An empty one takes the mask away.
  EXPECT_TRUE(orders.SetMask(cv::Mat()).ok());
  EXPECT_TRUE(orders.Take().mask.has_value());
}

}  // namespace
}  // namespace corbslam::client_agent
