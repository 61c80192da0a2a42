#include "slam/sensor/worker_thread.h"

#include <utility>

namespace corbslam {

WorkerThread::WorkerThread() : thread_([this] { Loop(); }) {}

WorkerThread::~WorkerThread() {
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
  }
  thread_.join();
}

void WorkerThread::Start(std::function<void()> work) {
  absl::MutexLock lock(&mutex_);
  work_ = std::move(work);
}

void WorkerThread::Wait() {
  const auto idle = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return work_ == nullptr; };
  absl::MutexLock lock(&mutex_, absl::Condition(&idle));
}

void WorkerThread::Loop() {
  const auto ready = [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return work_ != nullptr || stop_;
  };
  while (true) {
    std::function<void()> work;
    {
      absl::MutexLock lock(&mutex_, absl::Condition(&ready));
      if (work_ == nullptr) return;
      work = work_;
    }
    work();
    absl::MutexLock lock(&mutex_);
    work_ = nullptr;
  }
}

}  // namespace corbslam
