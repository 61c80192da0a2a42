#include "services/server/stream_task.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "absl/synchronization/notification.h"
#include "absl/time/time.h"

namespace corbslam::services {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

enum class Job { kNone, kStep, kFinish };

// Does a step for each one that was noted, and finishes once the end was noted.
class CountingTask : public StreamTask<Job> {
 public:
  explicit CountingTask(TaskPool& pool, Threads threads = Threads::kTasks)
      : StreamTask(pool, threads) {}

  void NoteStep() {
    Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { ++noted_; });
  }
  void NoteNothing() {
    Note([] {});
  }
  void NoteEnd() {
    Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { ended_ = true; });
  }
  void NeverStart() { NeverWork(); }
  std::function<void()> StepListener() {
    return link_.Guard([this] { NoteStep(); });
  }
  void CutLink() { link_.Cut(); }

  // Waits for the last job.
  void WaitForEnd() { finish_.WaitForNotification(); }
  std::vector<Job> done() const {
    absl::MutexLock lock(&mutex_);
    return done_;
  }
  int most_at_once() const {
    absl::MutexLock lock(&mutex_);
    return most_at_once_;
  }
  // Makes the next step wait until `go` is notified.
  void HoldStep(absl::Notification* begun, absl::Notification* go) {
    absl::MutexLock lock(&mutex_);
    begun_ = begun;
    go_ = go;
  }

 private:
  Job NextJob() const override ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    if (noted_ > 0) return Job::kStep;
    return ended_ ? Job::kFinish : Job::kNone;
  }
  void BeginJob(Job job) override ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (job == Job::kStep) --noted_;
  }
  void DoJob(Job job) override {
    absl::Notification* begun = nullptr;
    absl::Notification* go = nullptr;
    {
      absl::MutexLock lock(&mutex_);
      most_at_once_ = std::max(most_at_once_, ++at_once_);
      std::swap(begun, begun_);
      std::swap(go, go_);
    }
    if (begun != nullptr) begun->Notify();
    if (go != nullptr) go->WaitForNotification();
    {
      absl::MutexLock lock(&mutex_);
      --at_once_;
      done_.push_back(job);
    }
    if (job == Job::kFinish) finish_.Notify();
  }

  int noted_ ABSL_GUARDED_BY(mutex_) = 0;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  int at_once_ ABSL_GUARDED_BY(mutex_) = 0;
  int most_at_once_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Notification* begun_ ABSL_GUARDED_BY(mutex_) = nullptr;
  absl::Notification* go_ ABSL_GUARDED_BY(mutex_) = nullptr;
  std::vector<Job> done_ ABSL_GUARDED_BY(mutex_);
  absl::Notification finish_;
};

TEST(StreamTaskTest, DoesWhatWasNotedAndFinishesLast) {
  TaskPool pool(2);
  CountingTask task(pool);
  task.NoteStep();
  task.NoteStep();
  task.NoteEnd();
  task.WaitForEnd();
  EXPECT_THAT(task.done(), ElementsAre(Job::kStep, Job::kStep, Job::kFinish));
}

TEST(StreamTaskTest, LookUpsWorkOnTheirOwnThreads) {
  TaskPool pool(1);
  // The pool's one thread of tasks is busy.
  absl::Notification busy;
  pool.Schedule([&busy] { busy.WaitForNotification(); });
  CountingTask task(pool, CountingTask::Threads::kLookUps);
  task.NoteStep();
  task.NoteEnd();
  task.WaitForEnd();
  busy.Notify();
  EXPECT_THAT(task.done(), ElementsAre(Job::kStep, Job::kFinish));
}

TEST(StreamTaskTest, NothingToDoTakesNoThread) {
  auto pool = std::make_unique<TaskPool>(1);
  absl::Notification busy;
  pool->Schedule([&busy] { busy.WaitForNotification(); });
  CountingTask task(*pool);
  task.NoteNothing();
  // The blocking task may or may not have begun; nothing else waits.
  EXPECT_LE(pool->waiting(), 1u);
  task.NoteStep();
  task.NoteStep();
  // However much is noted, the task waits for a thread once.
  EXPECT_LE(pool->waiting(), 2u);
  busy.Notify();
  pool.reset();
  EXPECT_THAT(task.done(), ElementsAre(Job::kStep, Job::kStep));
}

TEST(StreamTaskTest, WhatIsNotedWhileItWorksIsDoneByTheSameThread) {
  auto pool = std::make_unique<TaskPool>(4);
  CountingTask task(*pool);
  absl::Notification begun;
  absl::Notification go;
  task.HoldStep(&begun, &go);
  task.NoteStep();
  begun.WaitForNotification();
  task.NoteStep();
  task.NoteEnd();
  // The other threads find nothing to take.
  EXPECT_EQ(pool->waiting(), 0u);
  EXPECT_THAT(task.done(), IsEmpty());
  go.Notify();
  task.WaitForEnd();
  EXPECT_THAT(task.done(), ElementsAre(Job::kStep, Job::kStep, Job::kFinish));
}

TEST(StreamTaskTest, ManyNotesAtOnceAreEachDoneOnceAndOneAtATime) {
  constexpr int kThreads = 4;
  constexpr int kNotes = 2000;
  TaskPool pool(4);
  CountingTask task(pool);
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([&task] {
      for (int note = 0; note < kNotes; ++note) task.NoteStep();
    });
  }
  for (std::thread& thread : threads) thread.join();
  task.NoteEnd();
  task.WaitForEnd();
  EXPECT_EQ(task.done().size(), size_t{kThreads * kNotes + 1});
  EXPECT_EQ(task.most_at_once(), 1);
}

TEST(StreamTaskTest, NothingIsDoneAfterTheEnd) {
  auto pool = std::make_unique<TaskPool>(2);
  CountingTask task(*pool);
  task.NoteEnd();
  task.WaitForEnd();
  task.NoteStep();
  task.NoteEnd();
  pool.reset();
  EXPECT_THAT(task.done(), ElementsAre(Job::kFinish));
}

TEST(StreamTaskTest, ARefusedStreamNeverWorks) {
  auto pool = std::make_unique<TaskPool>(2);
  CountingTask task(*pool);
  task.NeverStart();
  task.NoteStep();
  task.NoteEnd();
  pool.reset();
  EXPECT_THAT(task.done(), IsEmpty());
}

TEST(StreamTaskTest, ListenersReachItUntilTheLinkIsCut) {
  auto pool = std::make_unique<TaskPool>(2);
  std::function<void()> listener;
  {
    CountingTask task(*pool);
    listener = task.StepListener();
    listener();
    task.CutLink();
    listener();
    pool.reset();
    EXPECT_THAT(task.done(), ElementsAre(Job::kStep));
  }
  // The task is gone: the address sanitizer would find a call of it.
  listener();
}

TEST(StreamLinkTest, CuttingWaitsForAnActionUnderWay) {
  StreamLink link;
  absl::Notification begun;
  absl::Notification go;
  bool is_done = false;
  const std::function<void()> action = link.Guard([&] {
    begun.Notify();
    go.WaitForNotification();
    is_done = true;
  });
  std::thread caller([&action] { action(); });
  begun.WaitForNotification();
  std::thread releaser([&go] { go.Notify(); });
  link.Cut();
  EXPECT_TRUE(is_done);
  caller.join();
  releaser.join();
}

}  // namespace
}  // namespace corbslam::services
