#include "services/server/task_pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "absl/synchronization/blocking_counter.h"
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

// A pool of one thread of each kind; that of look-ups is busy until it is let go.
class BusyPool {
 public:
  explicit BusyPool(size_t max_waiting_calls) : pool_(1, max_waiting_calls) {
    pool_.ScheduleLookUp([this] {
      busy_.Notify();
      free_.WaitForNotification();
    });
    busy_.WaitForNotification();
  }
  TaskPool& operator*() { return pool_; }
  void LetGo() { free_.Notify(); }

 private:
  absl::Notification busy_;
  absl::Notification free_;
  TaskPool pool_;
};

TEST(TaskPoolTest, SoManyCallsWaitAndNoMoreWhateverElseDoes) {
  std::vector<std::string> ran;
  {
    BusyPool pool(/*max_waiting_calls=*/2);
    (*pool).ScheduleLookUp([&] { ran.push_back("look-up"); });
    EXPECT_TRUE((*pool).ScheduleCall([&] { ran.push_back("first"); }).ok());
    EXPECT_TRUE((*pool).ScheduleCall([&] { ran.push_back("second"); }).ok());
    const absl::Status refused = (*pool).ScheduleCall([&] { ran.push_back("third"); });
    EXPECT_TRUE(absl::IsResourceExhausted(refused)) << refused;
    EXPECT_THAT(std::string(refused.message()), HasSubstr("2 calls waiting; the limit is 2"));
    EXPECT_EQ((*pool).waiting(), 3u);
    absl::Notification begun;
    (*pool).ScheduleLookUp([&] { begun.Notify(); });
    pool.LetGo();
    begun.WaitForNotification();
    EXPECT_TRUE((*pool).ScheduleCall([&] { ran.push_back("late"); }).ok());
  }
  EXPECT_THAT(ran, ElementsAre("look-up", "first", "second", "late"));
}

TEST(TaskPoolTest, TasksDoNotWaitForLookUpsNorLookUpsForTasks) {
  absl::Notification free;
  absl::BlockingCounter looking_up(2);
  absl::BlockingCounter tasks(8);
  TaskPool pool(8);
  for (int i = 0; i < 10; ++i) {
    pool.ScheduleLookUp([&, i] {
      if (i < 2) looking_up.DecrementCount();
      free.WaitForNotification();
    });
    pool.Schedule([&, i] {
      if (i < 8) tasks.DecrementCount();
      free.WaitForNotification();
    });
  }
  looking_up.Wait();
  tasks.Wait();
  EXPECT_EQ(pool.waiting(), 10u);
  free.Notify();
}

TEST(TaskPoolTest, LookUpsHaveLessOfAProcessorThanTasks) {
  const auto niceness = [] { return getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())); };
  int of_task = 0;
  int of_look_up = 0;
  {
    TaskPool pool(1);
    pool.Schedule([&] { of_task = niceness(); });
    pool.ScheduleLookUp([&] { of_look_up = niceness(); });
  }
  EXPECT_EQ(of_task, niceness());
  EXPECT_GT(of_look_up, of_task);
}

}  // namespace
}  // namespace corbslam
