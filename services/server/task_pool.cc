#include "services/server/task_pool.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/util/named_thread.h"
#include "slam/util/thread_priority.h"

namespace corbslam::services {
namespace {

// A look-up's thread has a niceness that is so many steps higher than a task's: it gets a third of
// the time that a task's thread is given, where there is not enough for both. Look-ups hold locks
// that tasks wait for, so that they must not get much less.
constexpr int kLookUpStepsLower = 5;
// What takes long gets a third of what look-ups then get. It holds locks for moments only.
constexpr int kLongWorkStepsLower = 10;

}  // namespace

TaskPool::TaskPool(int threads, size_t max_waiting_calls)
    : TaskPool(threads, std::max(1, threads / 4), kLookUpStepsLower, max_waiting_calls) {}

TaskPool::TaskPool(int threads, int look_up_threads, int steps_lower, size_t max_waiting_calls)
    : max_waiting_calls_(max_waiting_calls) {
  for (int i = 0; i < threads; ++i) {
    threads_.push_back(StartThread("tasks", [this] { RunTasks(); }));
  }
  for (int i = 0; i < look_up_threads; ++i) {
    threads_.push_back(StartThread("look-ups", [this, steps_lower] { RunLookUps(steps_lower); }));
  }
}

std::unique_ptr<TaskPool> TaskPool::ForLookUps(int threads, size_t max_waiting_calls) {
  return std::unique_ptr<TaskPool>(new TaskPool(0, threads, kLookUpStepsLower, max_waiting_calls));
}

std::unique_ptr<TaskPool> TaskPool::ForLongWork(int threads, size_t max_waiting_calls) {
  return std::unique_ptr<TaskPool>(
      new TaskPool(0, threads, kLongWorkStepsLower, max_waiting_calls));
}

TaskPool::~TaskPool() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  for (std::thread& thread : threads_) thread.join();
}

void TaskPool::Schedule(std::function<void()> task) {
  absl::MutexLock lock(&mutex_);
  tasks_.push_back(std::move(task));
}

void TaskPool::ScheduleLookUp(std::function<void()> task) {
  absl::MutexLock lock(&mutex_);
  look_ups_.push_back({.run = std::move(task), .is_call = false});
}

absl::Status TaskPool::ScheduleCall(std::function<void()> task) {
  absl::MutexLock lock(&mutex_);
  if (waiting_calls_ >= max_waiting_calls_) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "this server has ", waiting_calls_, " calls waiting; the limit is ", max_waiting_calls_));
  }
  ++waiting_calls_;
  look_ups_.push_back({.run = std::move(task), .is_call = true});
  return absl::OkStatus();
}

size_t TaskPool::waiting() const {
  absl::MutexLock lock(&mutex_);
  return tasks_.size() + look_ups_.size();
}

void TaskPool::RunTasks() {
  while (true) {
    Task task;
    {
      absl::MutexLock lock(&mutex_, absl::Condition(this, &TaskPool::IsTaskThere));
      if (tasks_.empty()) return;
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    task();
  }
}

void TaskPool::RunLookUps(int steps_lower) {
  StepBehindRobots(steps_lower, "look-ups");
  while (true) {
    LookUp look_up;
    {
      absl::MutexLock lock(&mutex_, absl::Condition(this, &TaskPool::IsLookUpThere));
      if (look_ups_.empty()) return;
      look_up = std::move(look_ups_.front());
      look_ups_.pop_front();
      if (look_up.is_call) --waiting_calls_;
    }
    look_up.run();
  }
}

}  // namespace corbslam::services
