// A caller and one thread beside it that share what there is to do.
#ifndef CORBSLAM_SLAM_SENSOR_THREAD_PAIR_H_
#define CORBSLAM_SLAM_SENSOR_THREAD_PAIR_H_

#include <atomic>
#include <cstddef>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/functional/function_ref.h"
#include "absl/synchronization/mutex.h"

namespace corbslam {

// Run is called by one thread, mostly several times in a row: between two of them, and where one
// waits for the other's last task, the threads stay awake for a moment. Schedulers put a thread
// that wakes beside the one that woke it, for milliseconds, while another processor sleeps: virtual
// machines' mostly do. So the thread beside the caller keeps off the caller's processor.
class ThreadPair {
 public:
  using Task = absl::FunctionRef<void(size_t)>;

  // If not `parallel` there is no second thread, and the caller does everything, in order.
  explicit ThreadPair(bool parallel);
  ~ThreadPair();
  ThreadPair(const ThreadPair&) = delete;
  ThreadPair& operator=(const ThreadPair&) = delete;

  // Runs task(0) to task(count - 1), each once, and returns when all are done. The thread that is
  // free takes the next one: a thread that the machine does not let run delays nothing that it has
  // not begun. Tasks must not throw.
  void Run(size_t count, Task task);

 private:
  // Returns false when no task is left to begin.
  bool RunOne();
  void Loop();
  void KeepApart();

  absl::Mutex mutex_;
  // Threads that are awake read here whether there is something to begin, and whether all is done.
  std::atomic<bool> to_begin_ = false;
  std::atomic<bool> all_done_ = true;
  int kept_off_ = -1;  // The processor that the thread must not use; -1: any will do.
  const Task* task_ ABSL_GUARDED_BY(mutex_) = nullptr;
  size_t count_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t begun_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t done_ ABSL_GUARDED_BY(mutex_) = 0;
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // There may be no thread.
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_THREAD_PAIR_H_
