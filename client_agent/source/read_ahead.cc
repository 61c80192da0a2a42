#include "client_agent/source/read_ahead.h"

#include <algorithm>
#include <utility>

#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {

ReadAhead::ReadAhead(size_t capacity, Read read)
    : capacity_(std::max<size_t>(capacity, 1)),
      read_(std::move(read)),
      thread_(StartThread("read ahead", [this] { Run(); })) {}

ReadAhead::~ReadAhead() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  thread_.join();
}

bool ReadAhead::HasRoom() const { return stopping_ || ready_.size() < capacity_; }
bool ReadAhead::HasSomething() const { return finished_ || !ready_.empty(); }

void ReadAhead::Run() {
  for (size_t i = 0;; ++i) {
    absl::StatusOr<std::optional<StreamFrame>> frame = read_(i);
    absl::MutexLock lock(&mutex_);
    finished_ = frame.ok() && !frame->has_value();
    if (finished_) return;
    mutex_.Await(absl::Condition(this, &ReadAhead::HasRoom));
    if (stopping_) return;
    if (frame.ok()) {
      ready_.push_back(**std::move(frame));
    } else {
      ready_.push_back(frame.status());
    }
  }
}

absl::StatusOr<std::optional<StreamFrame>> ReadAhead::Next() {
  absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(this, &ReadAhead::HasSomething));
  if (ready_.empty()) return std::nullopt;
  absl::StatusOr<StreamFrame> frame = std::move(ready_.front());
  ready_.pop_front();
  RETURN_IF_ERROR(frame.status());
  return *std::move(frame);
}

}  // namespace corbslam::client_agent
