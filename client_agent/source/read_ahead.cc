#include "client_agent/source/read_ahead.h"

#include <algorithm>
#include <utility>

#include "slam/util/status_macros.h"

namespace corbslam {

ReadAhead::ReadAhead(size_t count, size_t capacity, Read read)
    : capacity_(std::max<size_t>(capacity, 1)),
      read_(std::move(read)),
      thread_([this, count] { Run(count); }) {}

ReadAhead::~ReadAhead() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  thread_.join();
}

bool ReadAhead::HasRoom() const { return stopping_ || ready_.size() < capacity_; }
bool ReadAhead::HasSomething() const { return finished_ || !ready_.empty(); }

void ReadAhead::Run(size_t count) {
  for (size_t i = 0; i < count; ++i) {
    absl::StatusOr<SensorImages> images = read_(i);
    absl::MutexLock lock(&mutex_);
    mutex_.Await(absl::Condition(this, &ReadAhead::HasRoom));
    if (stopping_) return;
    ready_.push_back(std::move(images));
  }
  absl::MutexLock lock(&mutex_);
  finished_ = true;
}

absl::StatusOr<std::optional<SensorImages>> ReadAhead::Next() {
  absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(this, &ReadAhead::HasSomething));
  if (ready_.empty()) return std::nullopt;
  absl::StatusOr<SensorImages> images = std::move(ready_.front());
  ready_.pop_front();
  RETURN_IF_ERROR(images.status());
  return *std::move(images);
}

}  // namespace corbslam
