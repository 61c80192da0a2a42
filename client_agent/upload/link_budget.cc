#include "client_agent/upload/link_budget.h"

#include <algorithm>

namespace corbslam::client_agent {
namespace {

// A smaller batch is mostly its own frame.
constexpr double kLeastBatchBytes = 512;
// Weight of what the newest batch took in the scale, which says what the next ones will take.
constexpr double kNewestShare = 0.25;
constexpr double kLeastScale = 0.1;
constexpr double kMostScale = 4;

}  // namespace

bool LinkBudget::is_bounded() const {
  absl::MutexLock lock(&mutex_);
  return bucket_.is_bounded() && !lifted_;
}

void LinkBudget::SetRate(uint64_t bytes_per_second) {
  absl::MutexLock lock(&mutex_);
  bytes_per_second_ = bytes_per_second;
  bucket_ = ByteBucket(bytes_per_second);
}

uint64_t LinkBudget::bytes_per_second() const {
  absl::MutexLock lock(&mutex_);
  return bytes_per_second_;
}

void LinkBudget::Lift() {
  absl::MutexLock lock(&mutex_);
  lifted_ = true;
}

void LinkBudget::NoteTransport(const Uplink& uplink, absl::Time now) {
  // Bytes that move on between the two calls count twice until the next time, rather than never.
  const uint64_t waiting = uplink.bytes_waiting();
  NoteTransport(uplink.bytes_up(), waiting, now);
}

void LinkBudget::NoteTransport(uint64_t written, uint64_t waiting, absl::Time now) {
  absl::MutexLock lock(&mutex_);
  // The sum is less than before where a session broke and what waited in it was not sent.
  bucket_.Spend(static_cast<int64_t>(written + waiting - accounted_), now);
  accounted_ = written + waiting;
  waiting_ = waiting;
}

void LinkBudget::NoteSent(const MapUpdateBatch& batch, uint64_t bytes) {
  if (bytes == 0) return;
  const double took = static_cast<double>(bytes) / static_cast<double>(EstimateWireBytes(batch));
  absl::MutexLock lock(&mutex_);
  scale_ += kNewestShare * (std::clamp(took, kLeastScale, kMostScale) - scale_);
}

bool LinkBudget::MaySend(absl::Time now) {
  absl::MutexLock lock(&mutex_);
  return lifted_ || bucket_.Level(now) > 0;
}

bool LinkBudget::MayTake(absl::Time now) {
  absl::MutexLock lock(&mutex_);
  if (lifted_ || !bucket_.is_bounded()) return true;
  return waiting_ == 0 && bucket_.Level(now) > 0;
}

bool LinkBudget::CanSpare(uint64_t bytes, absl::Time now) {
  absl::MutexLock lock(&mutex_);
  if (lifted_ || !bucket_.is_bounded()) return true;
  // The bucket holds what comes in a second.
  const auto half = static_cast<int64_t>(bytes_per_second_ / 2);
  return waiting_ == 0 && bucket_.Level(now) - static_cast<int64_t>(bytes) >= half;
}

BatchAllowance LinkBudget::Allow(size_t max_keyframes, absl::Time now) {
  absl::MutexLock lock(&mutex_);
  if (lifted_ || !bucket_.is_bounded()) return BatchAllowance(max_keyframes);
  const double level = static_cast<double>(bucket_.Level(now));
  return BatchAllowance(max_keyframes, std::max(level, kLeastBatchBytes), scale_);
}

}  // namespace corbslam::client_agent
