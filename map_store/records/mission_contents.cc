#include "map_store/records/mission_contents.h"

#include <algorithm>

#include "absl/container/flat_hash_set.h"

namespace corbslam::map_store {
namespace {

// A snapshot for less would cost more than it gives back.
constexpr uint64_t kLeastRemoved = 8 << 20;

}  // namespace

void MissionContents::NoteRecord(Position position, uint64_t bytes) {
  records_[position] = bytes;
  record_bytes_ += bytes;
}

void MissionContents::NoteFeatures(KeyframeId id, Position position, uint64_t bytes) {
  StoredFeatures& stored = features_[id];
  Keep(stored);
  feature_bytes_ += bytes - stored.bytes;
  stored = {position, bytes, 0};
}

void MissionContents::NoteRemoved(KeyframeId id, Position position) {
  const auto it = features_.find(id);
  if (it == features_.end() || it->second.removed_at != 0) return;
  it->second.removed_at = position;
  removed_bytes_ += it->second.bytes;
}

void MissionContents::Keep(StoredFeatures& stored) {
  if (stored.removed_at != 0) removed_bytes_ -= stored.bytes;
  stored.removed_at = 0;
}

void MissionContents::NoteSnapshot(Position position, uint64_t bytes,
                                   const std::vector<KeyframeId>& dropped) {
  snapshot_position_ = position;
  snapshot_bytes_ = bytes;
  const auto end = records_.upper_bound(position);
  for (auto it = records_.begin(); it != end; ++it) record_bytes_ -= it->second;
  records_.erase(records_.begin(), end);
  for (const KeyframeId& id : dropped) {
    const auto it = features_.find(id);
    if (it == features_.end()) continue;
    Keep(it->second);
    feature_bytes_ -= it->second.bytes;
    features_.erase(it);
  }
  // What is still needed would want the next snapshot at once.
  for (auto& [id, stored] : features_) {
    if (stored.removed_at <= position) Keep(stored);
  }
}

std::vector<KeyframeId> MissionContents::FindUnneeded(const JournalSnapshot& snapshot) const {
  const absl::flat_hash_set<KeyframeId> needed(snapshot.keyframes.begin(),
                                               snapshot.keyframes.end());
  std::vector<KeyframeId> unneeded;
  for (const auto& [id, stored] : features_) {
    if (stored.position <= snapshot.position && !needed.contains(id)) unneeded.push_back(id);
  }
  return unneeded;
}

bool MissionContents::WantsSnapshot(uint64_t min_bytes) const {
  if (record_bytes_ > std::max(min_bytes, snapshot_bytes_)) return true;
  return removed_bytes_ > std::min(min_bytes, kLeastRemoved) && removed_bytes_ > feature_bytes_ / 4;
}

}  // namespace corbslam::map_store
