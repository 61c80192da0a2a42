// Threads for work that would hold up gRPC's own.
#ifndef CORBSLAM_SERVICES_SERVER_TASK_POOL_H_
#define CORBSLAM_SERVICES_SERVER_TASK_POOL_H_

#include <cstddef>
#include <deque>
#include <functional>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"

namespace corbslam {

// Thread-safe. Tasks begin in the order in which they came.
class TaskPool {
 public:
  static constexpr size_t kMaxWaitingCalls = 256;

  explicit TaskPool(int threads, size_t max_waiting_calls = kMaxWaitingCalls);
  // Runs what was scheduled, then ends.
  ~TaskPool();
  TaskPool(const TaskPool&) = delete;
  TaskPool& operator=(const TaskPool&) = delete;

  // Whoever schedules bounds how many wait.
  void Schedule(std::function<void()> task);
  // For calls, of which anybody may make any number. RESOURCE_EXHAUSTED: too many wait already.
  absl::Status ScheduleCall(std::function<void()> task);
  // Scheduled and not begun.
  size_t waiting() const;
  int threads() const { return static_cast<int>(threads_.size()); }

 private:
  struct Task {
    std::function<void()> run;
    bool is_call = false;
  };

  void Run();
  bool HasNews() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return stopping_ || !tasks_.empty(); }

  const size_t max_waiting_calls_;
  mutable absl::Mutex mutex_;
  std::deque<Task> tasks_ ABSL_GUARDED_BY(mutex_);
  size_t waiting_calls_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SERVER_TASK_POOL_H_
