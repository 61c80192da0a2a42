// A thread that lives as long as its owner and runs one piece of work at a time.
#ifndef CORBSLAM_SLAM_SENSOR_WORKER_THREAD_H_
#define CORBSLAM_SLAM_SENSOR_WORKER_THREAD_H_

#include <functional>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"

namespace corbslam {

// Start and Wait are called by one thread, in turns.
class WorkerThread {
 public:
  WorkerThread();
  // Waits for the work under way.
  ~WorkerThread();
  WorkerThread(const WorkerThread&) = delete;
  WorkerThread& operator=(const WorkerThread&) = delete;

  // Runs `work` on the thread; what it uses must live until Wait returns.
  void Start(std::function<void()> work);
  void Wait();

 private:
  void Loop();

  absl::Mutex mutex_;
  std::function<void()> work_ ABSL_GUARDED_BY(mutex_);  // empty: none
  bool stop_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_SENSOR_WORKER_THREAD_H_
