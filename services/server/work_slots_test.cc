#include "services/server/work_slots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

TEST(WorkSlotsTest, BoundsAllAndCallersAndResources) {
  WorkSlots work({.what = "backups", .all = 4, .of_caller = 3, .of_resource = 2});
  const auto first = work.Enter("ann", "missions/a");
  auto second = work.Enter("ann", "missions/a");
  ASSERT_TRUE(first.ok() && second.ok());
  const auto third_of_mission = work.Enter("bob", "missions/a");
  EXPECT_EQ(third_of_mission.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(third_of_mission.status().message()),
              HasSubstr("missions/a has 2 backups"));
  const auto third = work.Enter("ann", "missions/b");
  ASSERT_TRUE(third.ok());
  EXPECT_THAT(std::string(work.Enter("ann", "missions/c").status().message()),
              HasSubstr("ann has 3"));
  const auto fourth = work.Enter("bob", "missions/b");
  ASSERT_TRUE(fourth.ok());
  EXPECT_THAT(std::string(work.Enter("eve", "missions/c").status().message()),
              HasSubstr("this server has 4"));
  second->reset();
  EXPECT_EQ(work.size(), 3u);
  EXPECT_TRUE(work.Enter("bob", "missions/a").ok());
}

TEST(WorkSlotsTest, WorkMayOutliveTheCount) {
  std::optional<WorkSlots> work(
      WorkLimits{.what = "backups", .all = 1, .of_caller = 1, .of_resource = 1});
  auto entered = work->Enter("ann", "missions/a");
  ASSERT_TRUE(entered.ok());
  work.reset();
  entered->reset();
}

}  // namespace
}  // namespace corbslam::services
