#include "slam/util/memory_returner.h"

#include <cstdint>
#include <utility>

#include "slam/util/named_thread.h"
#include "slam/util/resident_memory.h"
#include "slam/util/thread_priority.h"

namespace corbslam {
namespace {

constexpr int kPriorityStepsLower = 10;
// Less is not worth looking for.
constexpr uint64_t kLeast_bytes = 4 << 20;

}  // namespace

MemoryReturner::MemoryReturner()
    : MemoryReturner([kept = HeapTrimmer(kLeast_bytes)]() mutable { kept.GiveBack(); }) {}

void MemoryReturner::Start() {
  thread_ = StartThread("memory returner", [this] { Run(); });
}

void MemoryReturner::Stop() {
  {
    absl::MutexLock lock(&mutex_);
    stopped_ = true;
  }
  if (thread_.joinable()) thread_.join();
}

void MemoryReturner::Wake() {
  absl::MutexLock lock(&mutex_);
  woken_ = true;
}

bool MemoryReturner::WaitForWake(absl::Duration most) {
  absl::MutexLock lock(&mutex_);
  const auto is_over = [this]()
                           ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return woken_ || stopped_; };
  mutex_.AwaitWithTimeout(absl::Condition(&is_over), most);
  return !stopped_;
}

bool MemoryReturner::TakeWake() {
  absl::MutexLock lock(&mutex_);
  return std::exchange(woken_, false);
}

bool MemoryReturner::Rest(absl::Duration time) {
  absl::MutexLock lock(&mutex_);
  mutex_.AwaitWithTimeout(absl::Condition(&stopped_), time);
  return !stopped_;
}

void MemoryReturner::Run() {
  // The allocator's locks are held meanwhile, a piece at a time.
  StepBehindRobots(kPriorityStepsLower, "giving memory back");
  absl::Duration most = absl::InfiniteDuration();
  while (WaitForWake(most) && Rest(pace_.pause)) {
    most = TakeWake() ? pace_.later : absl::InfiniteDuration();
    give_back_();
    if (!Rest(pace_.between - pace_.pause)) return;
  }
}

}  // namespace corbslam
