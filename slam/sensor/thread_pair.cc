#include "slam/sensor/thread_pair.h"

namespace corbslam {

ThreadPair::ThreadPair(bool parallel) {
  if (parallel) thread_ = std::thread([this] { Loop(); });
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
  {
    absl::MutexLock lock(&mutex_);
    task_ = &task;
    count_ = count;
    begun_ = 0;
    done_ = 0;
  }
  while (RunOne()) {
  }
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
    // What it refers to lives until this one is done, too.
    task = task_;
  }
  (*task)(index);
  absl::MutexLock lock(&mutex_);
  ++done_;
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
    while (RunOne()) {
    }
  }
}

}  // namespace corbslam
