// Gives the memory of what is gone back to the system, on a thread of its own.
#ifndef CORBSLAM_SLAM_UTIL_MEMORY_RETURNER_H_
#define CORBSLAM_SLAM_UTIL_MEMORY_RETURNER_H_

#include <functional>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace corbslam {

// The allocator keeps what is freed, for ever where something small lies above it. Thread-safe.
class MemoryReturner {
 public:
  struct Pace {
    // From a wake to giving back: who frees one thing often frees the next one, and streams end a
    // moment after what they were about.
    absl::Duration pause = absl::Seconds(2);
    // From one time to the next: looking at all of the heap holds up those who allocate.
    absl::Duration between = absl::Seconds(10);
    // From the last wake to another time: what is put away only when nothing comes any more, as the
    // buffers of a journal are, wakes nobody.
    absl::Duration later = absl::Seconds(45);
  };

  // Gives back what is worth it.
  MemoryReturner();
  // `give_back` does it; it may take a while.
  explicit MemoryReturner(std::function<void()> give_back)
      : MemoryReturner(std::move(give_back), Pace()) {}
  MemoryReturner(std::function<void()> give_back, const Pace& pace)
      : give_back_(std::move(give_back)), pace_(pace) {}
  ~MemoryReturner() { Stop(); }
  MemoryReturner(const MemoryReturner&) = delete;
  MemoryReturner& operator=(const MemoryReturner&) = delete;

  void Start();
  // Joins the thread.
  void Stop() ABSL_LOCKS_EXCLUDED(mutex_);
  // Tells the thread that something large was freed, or is about to be. Costs next to nothing.
  void Wake() ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  void Run();
  // Waits for a wake that came since the last time, and for `most` at most. Returns false once
  // stopped.
  bool WaitForWake(absl::Duration most) ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns whether somebody woke it since the last call.
  bool TakeWake() ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns false once stopped.
  bool Rest(absl::Duration time) ABSL_LOCKS_EXCLUDED(mutex_);

  const std::function<void()> give_back_;
  const Pace pace_;
  absl::Mutex mutex_;
  bool woken_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_UTIL_MEMORY_RETURNER_H_
