// Threads for work that would hold up gRPC's own.
#ifndef CORBSLAM_SERVICES_SERVER_TASK_POOL_H_
#define CORBSLAM_SERVICES_SERVER_TASK_POOL_H_

#include <cstddef>
#include <deque>
#include <functional>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace corbslam {

// Thread-safe. Tasks begin in the order in which they came. Whoever schedules bounds how many wait.
class TaskPool {
 public:
  explicit TaskPool(int threads);
  // Runs what was scheduled, then ends.
  ~TaskPool();
  TaskPool(const TaskPool&) = delete;
  TaskPool& operator=(const TaskPool&) = delete;

  void Schedule(std::function<void()> task);
  // Scheduled and not begun.
  size_t waiting() const;
  int threads() const { return static_cast<int>(threads_.size()); }

 private:
  void Run();
  bool HasNews() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return stopping_ || !tasks_.empty(); }

  mutable absl::Mutex mutex_;
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SERVER_TASK_POOL_H_
