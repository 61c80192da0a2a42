#include "services/server/task_pool.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace corbslam {
namespace {

// Then it is a look-up's turn: they come slowly under a flood of tasks, but they come.
constexpr int kMaxTasksInARow = 8;

}  // namespace

TaskPool::TaskPool(int threads, size_t max_waiting_calls)
    : max_waiting_calls_(max_waiting_calls), max_running_look_ups_(std::max(1, threads / 4)) {
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

TaskPool::Kind TaskPool::Next() const {
  const bool may_look_up = !look_ups_.empty() && running_look_ups_ < max_running_look_ups_;
  if (may_look_up && (tasks_.empty() || tasks_in_a_row_ >= kMaxTasksInARow)) return Kind::kLookUp;
  return tasks_.empty() ? Kind::kNone : Kind::kTask;
}

std::function<void()> TaskPool::Take(Kind kind) {
  if (kind == Kind::kTask) {
    tasks_in_a_row_ = look_ups_.empty() ? 0 : std::min(tasks_in_a_row_ + 1, kMaxTasksInARow);
    std::function<void()> task = std::move(tasks_.front());
    tasks_.pop_front();
    return task;
  }
  tasks_in_a_row_ = 0;
  ++running_look_ups_;
  LookUp look_up = std::move(look_ups_.front());
  look_ups_.pop_front();
  if (look_up.is_call) --waiting_calls_;
  return std::move(look_up.run);
}

void TaskPool::Run() {
  while (true) {
    Kind kind;
    std::function<void()> task;
    {
      absl::MutexLock lock(&mutex_, absl::Condition(this, &TaskPool::HasNews));
      if (IsOver()) return;
      kind = Next();
      task = Take(kind);
    }
    task();
    // What it holds may end streams: not under the lock, and before the next waits for news.
    task = nullptr;
    if (kind == Kind::kTask) continue;
    absl::MutexLock lock(&mutex_);
    --running_look_ups_;
  }
}

}  // namespace corbslam
