// Does what is left to do of local maps that a robot has left, beside tracking.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_AFTER_WORK_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_AFTER_WORK_H_

#include <deque>
#include <functional>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace corbslam::client_agent {

// One piece of work is done after the other, in the order in which they were posted, on a thread of
// their own. Thread-safe.
class AfterWork {
 public:
  using Work = std::function<void()>;

  // Without `threaded` there is no thread: Post does the work before it returns.
  explicit AfterWork(bool threaded);
  // Waits until all that was posted is done.
  ~AfterWork();
  AfterWork(const AfterWork&) = delete;
  AfterWork& operator=(const AfterWork&) = delete;

  // Never waits for work, where there is a thread.
  void Post(Work work);
  // Returns when nothing is left to do, or false at the deadline.
  bool WaitUntilIdle(absl::Time deadline) const;

 private:
  void Run();

  mutable absl::Mutex mutex_;
  std::deque<Work> waiting_ ABSL_GUARDED_BY(mutex_);
  bool busy_ ABSL_GUARDED_BY(mutex_) = false;
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_AFTER_WORK_H_
