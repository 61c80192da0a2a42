#include "client_agent/mapping/mapping_queue.h"

#include <utility>

namespace corbslam::client_agent {

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

template <typename Item>
std::optional<Item> MappingQueue::TryPop(std::deque<Item>& items) {
  if (items.empty()) return std::nullopt;
  std::optional<Item> item = std::move(items.front());
  items.pop_front();
  busy_ = true;
  return item;
}

std::optional<NewKeyframe> MappingQueue::TryPopKeyframe() {
  absl::MutexLock lock(&mutex_);
  return TryPop(keyframes_);
}

std::optional<MappingJob> MappingQueue::TryPopJob() {
  absl::MutexLock lock(&mutex_);
  return TryPop(jobs_);
}

void MappingQueue::Done() {
  absl::MutexLock lock(&mutex_);
  busy_ = false;
}

bool MappingQueue::WaitForWork() {
  absl::MutexLock lock(&mutex_);
  const auto awake = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return stopped_ || !Idle(); };
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

}  // namespace corbslam::client_agent
