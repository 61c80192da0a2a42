#include "services/observe/tracing/robot_trace.h"

#include "absl/time/clock.h"

namespace corbslam::services {

using client_agent::TrackingResult;

void RobotTrace::OnFrame(int64_t timestamp_ns) {
  absl::MutexLock lock(&mutex_);
  captured_[timestamp_ns] = absl::Now();
}

void RobotTrace::OnTracked(const TrackingResult& result, absl::Duration) {
  if (result.made_keyframe) return;
  absl::MutexLock lock(&mutex_);
  captured_.erase(result.timestamp_ns);
}

void RobotTrace::OnSent(const MapUpdateBatch& batch, absl::Time offered) {
  std::vector<KeyframeId> keyframes;
  std::vector<std::vector<KeyframeId>> acknowledged;
  {
    absl::MutexLock lock(&mutex_);
    for (const FullKeyframe& keyframe : batch.full_keyframes) {
      const KeyframeId id = keyframe.payload->id;
      keyframes.push_back(id);
      const auto captured = captured_.find(keyframe.payload->timestamp_ns);
      if (captured == captured_.end()) continue;
      file_.Add(Event(kCaptured, id, captured->second));
      captured_.erase(captured);
    }
    acknowledged = pending_.Sent(batch.local_map, batch.number, keyframes);
  }
  for (const KeyframeId& id : keyframes) file_.Add(Event(kSent, id, offered));
  NoteAcknowledged(acknowledged);
}

void RobotTrace::OnAcknowledged(const Acknowledgement& acknowledgement) {
  std::vector<std::vector<KeyframeId>> batches;
  {
    absl::MutexLock lock(&mutex_);
    batches = pending_.Acknowledged(acknowledgement);
  }
  NoteAcknowledged(batches);
}

void RobotTrace::NoteAcknowledged(const std::vector<std::vector<KeyframeId>>& batches) {
  const absl::Time now = absl::Now();
  for (const std::vector<KeyframeId>& keyframes : batches) {
    for (const KeyframeId& id : keyframes) file_.Add(Event(kAcknowledged, id, now));
  }
}

void RobotTrace::OnShared(const SharedUpdate& update) {
  const absl::Time now = absl::Now();
  for (const SharedKeyframe& keyframe : update.keyframes) {
    file_.Add(Event(kArrived, keyframe.payload->id, now));
  }
  absl::MutexLock lock(&mutex_);
  for (const OwnKeyframePose& own : update.own_keyframes) {
    if (posed_.insert(own.id).second) file_.Add(Event(kGlobalPose, own.id, now));
  }
}

}  // namespace corbslam::services
