#include "services/server/task_pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/synchronization/blocking_counter.h"
#include "absl/synchronization/notification.h"

namespace corbslam::services {
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

TEST(TaskPoolTest, PutsOffWhatItsDeferrerKnows) {
  TaskPool pool(1);
  const absl::Status missing = absl::NotFoundError("missing");
  const absl::Status late = absl::UnavailableError("late");
  EXPECT_EQ(pool.Defer(late, [](const auto&) {}), late) << "nobody knows what to wait for";
  TaskPool::Again kept;
  pool.SetDeferrer([&](const absl::Status& error, TaskPool::Again again) {
    if (!absl::IsUnavailable(error)) return error;
    kept = std::move(again);
    return absl::OkStatus();
  });
  EXPECT_EQ(pool.Defer(missing, [](const auto&) {}), missing);
  bool came = false;
  EXPECT_TRUE(pool.Defer(late, [&came](const auto& ready) { came = ready.ok(); }).ok());
  kept(std::make_shared<int>(0));
  EXPECT_TRUE(came);
}

// Holds a pool of one thread of each kind; the thread of look-ups is busy until it is let go.
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

int NicenessOfThisThread() { return getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())); }

// Runs a pool in a thread that has at least this niceness, as in a process that `nice` started, and
// compares the two kinds of threads.
void ExpectLookUpsBelowTasks(int niceness) {
  int of_task = 0;
  int of_look_up = 0;
  std::thread([&] {
    const int of_process = std::max(niceness, NicenessOfThisThread());
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), of_process);
    {
      TaskPool pool(1);
      pool.Schedule([&] { of_task = NicenessOfThisThread(); });
      pool.ScheduleLookUp([&] { of_look_up = NicenessOfThisThread(); });
    }
    EXPECT_EQ(of_task, of_process);
    EXPECT_EQ(of_look_up, std::min(19, of_process + 5)) << "of " << of_process;
  }).join();
}

TEST(TaskPoolTest, LookUpsHaveLessOfAProcessorThanTasksHoweverTheProcessWasStarted) {
  for (const int niceness : {0, 3, 15, 19}) ExpectLookUpsBelowTasks(niceness);
}

}  // namespace
}  // namespace corbslam::services
