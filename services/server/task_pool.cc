#include "services/server/task_pool.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace corbslam {

TaskPool::TaskPool(int threads, size_t max_waiting_calls) : max_waiting_calls_(max_waiting_calls) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { Run(); });
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
  tasks_.push_back({.run = std::move(task), .is_call = false});
}

absl::Status TaskPool::ScheduleCall(std::function<void()> task) {
  absl::MutexLock lock(&mutex_);
  if (waiting_calls_ >= max_waiting_calls_) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "this server has ", waiting_calls_, " calls waiting; the limit is ", max_waiting_calls_));
  }
  ++waiting_calls_;
  tasks_.push_back({.run = std::move(task), .is_call = true});
  return absl::OkStatus();
}

size_t TaskPool::waiting() const {
  absl::MutexLock lock(&mutex_);
  return tasks_.size();
}

void TaskPool::Run() {
  while (true) {
    std::function<void()> task;
    {
      absl::MutexLock lock(&mutex_, absl::Condition(this, &TaskPool::HasNews));
      if (tasks_.empty()) return;
      task = std::move(tasks_.front().run);
      if (tasks_.front().is_call) --waiting_calls_;
      tasks_.pop_front();
    }
    task();
  }
}

}  // namespace corbslam
