#include "services/map_store_service/streams/replay_slots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

namespace corbslam::services {
namespace {

TEST(ReplaySlotsTest, ReplaysBeyondTheLimitAreToldToTryAgain) {
  auto slots = std::make_unique<ReplaySlots>(2);
  auto first = slots->Take();
  const auto second = slots->Take();
  ASSERT_TRUE(first.ok() && second.ok());
  const absl::Status third = slots->Take().status();
  EXPECT_TRUE(absl::IsResourceExhausted(third)) << third;
  EXPECT_THAT(std::string(third.message()), ::testing::HasSubstr("2 replays already"));
  EXPECT_THAT(std::string(third.message()), ::testing::HasSubstr("try again"));
  EXPECT_EQ(slots->taken(), 2u);
  first->reset();
  EXPECT_EQ(slots->taken(), 1u);
  EXPECT_TRUE(slots->Take().ok());
  slots.reset();
}

}  // namespace
}  // namespace corbslam::services
