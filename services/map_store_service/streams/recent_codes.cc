#include "services/map_store_service/streams/recent_codes.h"

namespace corbslam::services {

void RecentCodes::OnOpened(const SessionAgent& who) {
  absl::MutexLock lock(&mutex_);
  ++sessions_[who.mission];
}

void RecentCodes::OnClosed(const SessionAgent& who, const absl::Status& /*status*/) {
  absl::MutexLock lock(&mutex_);
  const auto sessions = sessions_.find(who.mission);
  if (sessions == sessions_.end() || --sessions->second > 0) return;
  sessions_.erase(sessions);
  std::erase_if(codes_, [&](const Code& code) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (code.mission != who.mission) return false;
    bytes_ -= code.bytes->size();
    return true;
  });
}

void RecentCodes::OnApplied(const SessionAgent& who, const MapUpdateBatch& batch,
                            absl::Duration /*took*/, const absl::Status& status) {
  if (!status.ok()) return;
  const absl::Time now = clock_();
  absl::MutexLock lock(&mutex_);
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    if (keyframe.code == nullptr) continue;
    bytes_ += keyframe.code->size();
    codes_.push_back({who.mission, now, keyframe.code});
  }
  while (!codes_.empty() && (bytes_ > max_bytes_ || now - codes_.front().came > kMaxAge)) {
    bytes_ -= codes_.front().bytes->size();
    codes_.pop_front();
  }
}

size_t RecentCodes::bytes() const {
  absl::MutexLock lock(&mutex_);
  return bytes_;
}

}  // namespace corbslam::services
