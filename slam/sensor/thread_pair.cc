#include "slam/sensor/thread_pair.h"

#ifdef __linux__
#include <pthread.h>
#include <sched.h>
#endif

#include <chrono>

#include "slam/util/named_thread.h"

namespace corbslam {
namespace {

// The wait is longer than what a caller does alone between two runs of a frame, and shorter than
// what anybody would notice of a processor's time.
constexpr std::chrono::microseconds kAwake(500);

// Waits awake for at most kAwake, and lets other threads run meanwhile.
void StayAwakeUntil(const std::atomic<bool>& ready) {
  const auto end = std::chrono::steady_clock::now() + kAwake;
  while (!ready.load(std::memory_order_acquire) && std::chrono::steady_clock::now() < end) {
    std::this_thread::yield();
  }
}

#ifdef __linux__
// Returns all processors that this process may use, but one; none if that is all there are.
cpu_set_t ProcessorsBut(int one) {
  cpu_set_t processors;
  CPU_ZERO(&processors);
  sched_getaffinity(0, sizeof(processors), &processors);
  if (one >= 0) CPU_CLR(static_cast<size_t>(one), &processors);
  return processors;
}
#endif

}  // namespace

ThreadPair::ThreadPair(bool parallel) {
  if (parallel) thread_ = StartThread("feature half", [this] { Loop(); });
}

ThreadPair::~ThreadPair() {
  if (!thread_.joinable()) return;
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
  }
  thread_.join();
}

void ThreadPair::Run(size_t count, Task task) {
  if (!thread_.joinable()) {
    for (size_t i = 0; i < count; ++i) task(i);
    return;
  }
  KeepApart();
  {
    absl::MutexLock lock(&mutex_);
    task_ = &task;
    count_ = count;
    begun_ = 0;
    done_ = 0;
    to_begin_ = count > 0;
    all_done_ = count == 0;
  }
  while (RunOne()) {
  }
  StayAwakeUntil(all_done_);
  const auto all_done = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return done_ == count_; };
  absl::MutexLock lock(&mutex_, absl::Condition(&all_done));
}

bool ThreadPair::RunOne() {
  const Task* task = nullptr;
  size_t index = 0;
  {
    absl::MutexLock lock(&mutex_);
    if (begun_ == count_) return false;
    index = begun_++;
    to_begin_ = begun_ < count_;
    // The function that the task refers to lives until this task is done, too.
    task = task_;
  }
  (*task)(index);
  absl::MutexLock lock(&mutex_);
  ++done_;
  all_done_ = done_ == count_;
  return true;
}

void ThreadPair::Loop() {
  const auto ready = [this]()
                         ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return begun_ < count_ || stop_; };
  while (true) {
    {
      absl::MutexLock lock(&mutex_, absl::Condition(&ready));
      if (stop_) return;
    }
    do {
      while (RunOne()) {
      }
      StayAwakeUntil(to_begin_);
    } while (to_begin_);
  }
}

void ThreadPair::KeepApart() {
#ifdef __linux__
  const int here = sched_getcpu();
  if (here == kept_off_) return;
  const cpu_set_t others = ProcessorsBut(here);
  // The thread stays as it was where there is no other processor, and where the system refuses.
  if (CPU_COUNT(&others) == 0) return;
  kept_off_ = here;
  pthread_setaffinity_np(thread_.native_handle(), sizeof(others), &others);
#endif
}

}  // namespace corbslam
