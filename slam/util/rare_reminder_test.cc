#include "slam/util/rare_reminder.h"

#include <gtest/gtest.h>

#include <vector>

namespace corbslam {
namespace {

TEST(RareReminderTest, RemindsMoreAndMoreSeldom) {
  RareReminder reminder;
  std::vector<int> minutes;
  for (int minute = 0; minute <= 62; ++minute) {
    if (reminder.IsDue(absl::UnixEpoch() + absl::Minutes(minute))) minutes.push_back(minute);
  }
  EXPECT_EQ(minutes, (std::vector<int>{0, 1, 3, 7, 15, 30, 45, 60}));
}

TEST(RareReminderTest, BeginsAnewWhenItIsOver) {
  RareReminder reminder;
  EXPECT_TRUE(reminder.IsDue(absl::UnixEpoch()));
  EXPECT_FALSE(reminder.IsDue(absl::UnixEpoch()));
  reminder.Reset();
  EXPECT_TRUE(reminder.IsDue(absl::UnixEpoch()));
}

}  // namespace
}  // namespace corbslam
