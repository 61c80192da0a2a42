#include "client_agent/agent/agent_orders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;

TEST(AgentOrdersTest, EachOrderIsTakenOnceAndThePauseStays) {
  AgentOrders orders;
  orders.SetCamera({.width_px = 64, .height_px = 48});
  EXPECT_FALSE(orders.Take().open_local_map);
  ASSERT_TRUE(orders.OpenLocalMap().ok());
  ASSERT_TRUE(orders.SetMask(cv::Mat::zeros(48, 64, CV_8UC1)).ok());
  orders.PauseMapping(true);

  const OrdersForFrame first = orders.Take();
  EXPECT_TRUE(first.open_local_map);
  EXPECT_TRUE(first.mapping_paused);
  ASSERT_TRUE(first.mask.has_value());
  EXPECT_EQ(first.mask->cols, 64);

  const OrdersForFrame second = orders.Take();
  EXPECT_FALSE(second.open_local_map);
  EXPECT_FALSE(second.mask.has_value());
  EXPECT_TRUE(second.mapping_paused);
  orders.PauseMapping(false);
  EXPECT_FALSE(orders.Take().mapping_paused);
}

TEST(AgentOrdersTest, NoMapOpensWhileMappingIsPaused) {
  AgentOrders orders;
  orders.PauseMapping(true);
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
  // An empty one takes the mask away.
  EXPECT_TRUE(orders.SetMask(cv::Mat()).ok());
  EXPECT_TRUE(orders.Take().mask.has_value());
}

}  // namespace
}  // namespace corbslam::client_agent
