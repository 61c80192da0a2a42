// Provides threads for work that would hold up gRPC's own.
#ifndef CORBSLAM_SERVICES_SERVER_TASK_POOL_H_
#define CORBSLAM_SERVICES_SERVER_TASK_POOL_H_

#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"

namespace corbslam::services {

// Runs tasks that robots wait for, and look-ups, which have threads of their own: a quarter as many
// (or one), of lower priority, so that no number of them keeps robots waiting. Those of each kind
// begin in the order in which they came. Thread-safe.
class TaskPool {
 public:
  static constexpr size_t kMaxWaitingCalls = 256;

  // Starts `threads` for tasks, and those for look-ups.
  explicit TaskPool(int threads, size_t max_waiting_calls = kMaxWaitingCalls);
  // Starts threads for look-ups only.
  static std::unique_ptr<TaskPool> ForLookUps(int threads, size_t max_waiting_calls);
  // Starts threads for what takes long, of a priority that is lower than that of look-ups.
  static std::unique_ptr<TaskPool> ForLongWork(int threads, size_t max_waiting_calls);
  // Runs what was scheduled, then ends the threads.
  ~TaskPool();
  TaskPool(const TaskPool&) = delete;
  TaskPool& operator=(const TaskPool&) = delete;

  // Called when a call may be answered that could not be before: whatever it needs is there for as
  // long as somebody holds `ready`, or can't be had.
  using Again = std::function<void(const absl::StatusOr<std::shared_ptr<const void>>& ready)>;
  // Looks whether an error says that something is not there yet; if so sees to it that `again` is
  // called, once, by any thread, and returns OK. Else returns the error to answer with.
  using Deferrer = std::function<absl::Status(const absl::Status& error, Again again)>;
  // Sets what Defer asks; called before all else. Without, no call is put off.
  void SetDeferrer(Deferrer deferrer) { deferrer_ = std::move(deferrer); }
  absl::Status Defer(const absl::Status& error, Again again) const {
    return deferrer_ == nullptr ? error : deferrer_(error, std::move(again));
  }

  // The caller bounds how many tasks wait.
  void Schedule(std::function<void()> task);
  void ScheduleLookUp(std::function<void()> task);
  // Schedules a look-up that anybody may ask for, any number of times. RESOURCE_EXHAUSTED: too many
  // such look-ups wait already.
  absl::Status ScheduleCall(std::function<void()> task);
  // Returns the number of tasks and look-ups that are scheduled and not begun.
  size_t waiting() const;

 private:
  TaskPool(int threads, int look_up_threads, int steps_lower, size_t max_waiting_calls);

  using Task = std::function<void()>;
  struct LookUp {
    Task run;
    bool is_call = false;
  };

  // These run tasks of one kind, until the pool ends and none is left.
  void RunTasks();
  void RunLookUps(int steps_lower);
  bool IsTaskThere() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return stopping_ || !tasks_.empty();
  }
  bool IsLookUpThere() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return stopping_ || !look_ups_.empty();
  }

  const size_t max_waiting_calls_;
  Deferrer deferrer_;
  mutable absl::Mutex mutex_;
  std::deque<Task> tasks_ ABSL_GUARDED_BY(mutex_);
  std::deque<LookUp> look_ups_ ABSL_GUARDED_BY(mutex_);
  size_t waiting_calls_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<std::thread> threads_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SERVER_TASK_POOL_H_
