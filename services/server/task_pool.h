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

// Thread-safe. Tasks that robots wait for go first; look-ups, however many wait, have at most a
// quarter of the threads (or one). Of each kind they begin in the order in which they came.
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
  void ScheduleLookUp(std::function<void()> task);
  // A look-up that anybody may ask for, any number of times. RESOURCE_EXHAUSTED: too many such wait
  // already.
  absl::Status ScheduleCall(std::function<void()> task);
  // Scheduled and not begun.
  size_t waiting() const;
  int threads() const { return static_cast<int>(threads_.size()); }

 private:
  enum class Kind { kNone, kTask, kLookUp };
  struct LookUp {
    std::function<void()> run;
    bool is_call = false;
  };

  void Run();
  // What a free thread is to begin with.
  Kind Next() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  std::function<void()> Take(Kind kind) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool IsOver() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return stopping_ && tasks_.empty() && look_ups_.empty();
  }
  bool HasNews() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return IsOver() || Next() != Kind::kNone;
  }

  const size_t max_waiting_calls_;
  const int max_running_look_ups_;
  mutable absl::Mutex mutex_;
  std::deque<std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  std::deque<LookUp> look_ups_ ABSL_GUARDED_BY(mutex_);
  size_t waiting_calls_ ABSL_GUARDED_BY(mutex_) = 0;
  int running_look_ups_ ABSL_GUARDED_BY(mutex_) = 0;
  // Tasks begun while a look-up waited, since one was begun.
  int tasks_in_a_row_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SERVER_TASK_POOL_H_
