#include "services/server/task_pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/synchronization/notification.h"

namespace corbslam {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(TaskPoolTest, TasksBeginInOrderAndAllAreRunBeforeItEnds) {
  std::vector<int> ran;
  {
    TaskPool pool(1);
    for (int i = 0; i < 3; ++i) pool.Schedule([&ran, i] { ran.push_back(i); });
  }
  EXPECT_THAT(ran, ElementsAre(0, 1, 2));
}

TEST(TaskPoolTest, SoManyCallsWaitAndNoMoreWhateverElseDoes) {
  std::vector<std::string> ran;
  {
    TaskPool pool(1, /*max_waiting_calls=*/2);
    absl::Notification busy;
    absl::Notification free;
    pool.Schedule([&] {
      busy.Notify();
      free.WaitForNotification();
    });
    busy.WaitForNotification();
    for (int i = 0; i < 3; ++i) pool.Schedule([&] { ran.push_back("task"); });
    EXPECT_TRUE(pool.ScheduleCall([&] { ran.push_back("first"); }).ok());
    EXPECT_TRUE(pool.ScheduleCall([&] { ran.push_back("second"); }).ok());
    const absl::Status refused = pool.ScheduleCall([&] { ran.push_back("third"); });
    EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
    EXPECT_THAT(std::string(refused.message()), HasSubstr("2 calls waiting; the limit is 2"));
    EXPECT_EQ(pool.waiting(), 5u);

    absl::Notification begun;
    pool.Schedule([&] { begun.Notify(); });
    free.Notify();
    begun.WaitForNotification();
    EXPECT_TRUE(pool.ScheduleCall([&] { ran.push_back("late"); }).ok())
        << "those before have begun";
  }
  EXPECT_THAT(ran, ElementsAre("task", "task", "task", "first", "second", "late"));
}

}  // namespace
}  // namespace corbslam
