#include "client_agent/memory/outbox.h"

#include <utility>

#include "absl/container/btree_set.h"

namespace corbslam {

size_t ApproximateBytes(const MapUpdateBatch& batch) {
  constexpr size_t kFeatureBytes = sizeof(Keypoint) + sizeof(Descriptor);
  size_t bytes = 64;
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    bytes += 128 + kFeatureBytes * keyframe.payload->features.keypoints.size();
  }
  bytes += batch.cameras.size() * sizeof(Camera);
  bytes += batch.full_points.size() * sizeof(FullMapPoint);
  bytes += batch.light_keyframes.size() * sizeof(LightKeyframe);
  bytes += batch.light_points.size() * sizeof(LightMapPoint);
  bytes += batch.replacements.size() * sizeof(PointReplacement);
  bytes += batch.observations.size() * sizeof(ObservationChange);
  bytes += batch.removed_points.size() * sizeof(MapPointId);
  bytes += batch.removed_keyframes.size() * sizeof(KeyframeRemoval);
  bytes += batch.loop_edges.size() * sizeof(LoopEdge);
  bytes += batch.tracked_frames.size() * sizeof(TrackedFrame);
  bytes += batch.lost_frames_ns.size() * sizeof(int64_t);
  return bytes;
}

bool IsEmpty(const MapUpdateBatch& batch) {
  return batch.cameras.empty() && batch.full_keyframes.empty() && batch.full_points.empty() &&
         batch.light_keyframes.empty() && batch.light_points.empty() &&
         batch.replacements.empty() && batch.observations.empty() && batch.removed_points.empty() &&
         batch.removed_keyframes.empty() && batch.loop_edges.empty() &&
         batch.tracked_frames.empty() && batch.lost_frames_ns.empty() && !batch.closes_local_map;
}

void Outbox::Push(MapUpdateBatch batch) {
  batch.number = ++last_number_[batch.local_map];
  bytes_ += ApproximateBytes(batch);
  batches_.push_back(std::make_shared<const MapUpdateBatch>(std::move(batch)));
}

void Outbox::Acknowledge(const Acknowledgement& acknowledgement) {
  size_t kept = 0;
  size_t sent_kept = 0;
  for (size_t i = 0; i < batches_.size(); ++i) {
    const bool stored = batches_[i]->local_map == acknowledgement.local_map &&
                        batches_[i]->number <= acknowledgement.number;
    if (stored) {
      bytes_ -= ApproximateBytes(*batches_[i]);
      continue;
    }
    if (i < sent_) ++sent_kept;
    if (kept != i) batches_[kept] = std::move(batches_[i]);
    ++kept;
  }
  batches_.resize(kept);
  sent_ = sent_kept;
}

std::shared_ptr<const MapUpdateBatch> Outbox::NextUnsent() const {
  return sent_ < batches_.size() ? batches_[sent_] : nullptr;
}

std::vector<LocalMapId> Outbox::local_maps() const {
  absl::btree_set<LocalMapId> ids;
  for (const auto& batch : batches_) ids.insert(batch->local_map);
  return {ids.begin(), ids.end()};
}

}  // namespace corbslam
