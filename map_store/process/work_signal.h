// Tells threads that there may be something to do.
#ifndef CORBSLAM_MAP_STORE_PROCESS_WORK_SIGNAL_H_
#define CORBSLAM_MAP_STORE_PROCESS_WORK_SIGNAL_H_

#include <cstdint>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace corbslam::map_store {

// Counts wakes, so that a thread misses none. Thread-safe.
class WorkSignal {
 public:
  // Wakes all threads that wait.
  void Wake() {
    absl::MutexLock lock(&mutex_);
    ++wakes_;
  }
  // Ends all waiting, from here on.
  void Stop() {
    absl::MutexLock lock(&mutex_);
    stopped_ = true;
  }
  bool stopped() const {
    absl::MutexLock lock(&mutex_);
    return stopped_;
  }

  // Waits for a wake that this thread has not seen, and for `most` at most; `seen`, the thread's
  // own count, is 0 at first. Returns false once stopped.
  bool Wait(uint64_t& seen, absl::Duration most = absl::InfiniteDuration()) const {
    absl::MutexLock lock(&mutex_);
    const auto woken = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      return stopped_ || wakes_ != seen;
    };
    mutex_.AwaitWithTimeout(absl::Condition(&woken), most);
    seen = wakes_;
    return !stopped_;
  }
  // Waits for as long as `pause`, whoever wakes meanwhile. Returns false once stopped.
  bool WaitFor(absl::Duration pause) const {
    absl::MutexLock lock(&mutex_);
    mutex_.AwaitWithTimeout(absl::Condition(&stopped_), pause);
    return !stopped_;
  }

 private:
  mutable absl::Mutex mutex_;
  uint64_t wakes_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_PROCESS_WORK_SIGNAL_H_
