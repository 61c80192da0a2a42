#include "client_agent/mapping/mapping_queue.h"

#include <utility>

namespace corbslam {

bool MappingQueue::HasRoom() const {
  absl::MutexLock lock(&mutex_);
  return !stopped_ && keyframes_.size() < max_keyframes_;
}

bool MappingQueue::PushKeyframe(NewKeyframe keyframe) {
  absl::MutexLock lock(&mutex_);
  if (stopped_ || keyframes_.size() >= max_keyframes_) return false;
  keyframes_.push_back(std::move(keyframe));
  return true;
}

void MappingQueue::PostJob(MappingJob job) {
  absl::MutexLock lock(&mutex_);
  if (!stopped_) jobs_.push_back(std::move(job));
}

bool MappingQueue::IsIdle() const {
  absl::MutexLock lock(&mutex_);
  return Idle();
}

size_t MappingQueue::keyframes() const {
  absl::MutexLock lock(&mutex_);
  return keyframes_.size();
}

std::optional<MappingItem> MappingQueue::TryPop() {
  absl::MutexLock lock(&mutex_);
  std::optional<MappingItem> item;
  if (!jobs_.empty()) {
    item = std::move(jobs_.front());
    jobs_.pop_front();
  } else if (!keyframes_.empty()) {
    item = std::move(keyframes_.front());
    keyframes_.pop_front();
  }
  busy_ = busy_ || item.has_value();
  return item;
}

std::optional<NewKeyframe> MappingQueue::TryPopKeyframe() {
  absl::MutexLock lock(&mutex_);
  if (!jobs_.empty() || keyframes_.empty()) return std::nullopt;
  std::optional<NewKeyframe> keyframe = std::move(keyframes_.front());
  keyframes_.pop_front();
  busy_ = true;
  return keyframe;
}

void MappingQueue::Done() {
  absl::MutexLock lock(&mutex_);
  busy_ = false;
}

bool MappingQueue::WaitForItem() {
  absl::MutexLock lock(&mutex_);
  const auto awake = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return stopped_ || !jobs_.empty() || !keyframes_.empty();
  };
  mutex_.Await(absl::Condition(&awake));
  return !stopped_;
}

bool MappingQueue::WaitUntilIdle(absl::Time deadline) {
  absl::MutexLock lock(&mutex_);
  const auto idle = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return stopped_ || Idle(); };
  return mutex_.AwaitWithDeadline(absl::Condition(&idle), deadline);
}

void MappingQueue::Stop() {
  absl::MutexLock lock(&mutex_);
  stopped_ = true;
  jobs_.clear();
  keyframes_.clear();
}

}  // namespace corbslam
