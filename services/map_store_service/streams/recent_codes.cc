#include "services/map_store_service/streams/recent_codes.h"

namespace corbslam::services {

void RecentCodes::OnApplied(const SessionAgent& /*who*/, const MapUpdateBatch& batch,
                            absl::Duration /*took*/, const absl::Status& status) {
  if (!status.ok()) return;
  absl::MutexLock lock(&mutex_);
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    if (keyframe.code == nullptr) continue;
    bytes_ += keyframe.code->size();
    codes_.push_back(keyframe.code);
  }
  while (bytes_ > max_bytes_) {
    bytes_ -= codes_.front()->size();
    codes_.pop_front();
  }
}

size_t RecentCodes::bytes() const {
  absl::MutexLock lock(&mutex_);
  return bytes_;
}

}  // namespace corbslam::services
