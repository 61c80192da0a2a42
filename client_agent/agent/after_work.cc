#include "client_agent/agent/after_work.h"

#include <utility>

#include "slam/util/named_thread.h"

namespace corbslam::client_agent {

AfterWork::AfterWork(bool threaded) {
  if (threaded) thread_ = StartThread("after work", [this] { Run(); });
}

AfterWork::~AfterWork() {
  {
    absl::MutexLock lock(&mutex_);
    stop_ = true;
  }
  if (thread_.joinable()) thread_.join();
}

void AfterWork::Post(Work work) {
  if (!thread_.joinable()) return work();
  absl::MutexLock lock(&mutex_);
  waiting_.push_back(std::move(work));
}

bool AfterWork::WaitUntilIdle(absl::Time deadline) const {
  absl::MutexLock lock(&mutex_);
  const auto is_idle = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return waiting_.empty() && !busy_;
  };
  return mutex_.AwaitWithDeadline(absl::Condition(&is_idle), deadline);
}

void AfterWork::Run() {
  while (true) {
    Work next;
    {
      absl::MutexLock lock(&mutex_);
      busy_ = false;
      const auto has_work = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
        return stop_ || !waiting_.empty();
      };
      mutex_.Await(absl::Condition(&has_work));
      if (waiting_.empty()) return;
      next = std::move(waiting_.front());
      waiting_.pop_front();
      busy_ = true;
    }
    next();
  }
}

}  // namespace corbslam::client_agent
