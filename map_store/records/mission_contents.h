// Says what a journal holds of a mission, as far as it has to know it: how much of what, and
// what is needed no more.
#ifndef CORBSLAM_MAP_STORE_RECORDS_MISSION_CONTENTS_H_
#define CORBSLAM_MAP_STORE_RECORDS_MISSION_CONTENTS_H_

#include <cstdint>
#include <map>
#include <vector>

#include "map_store/records/journal.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Counts in bytes of values. Not thread-safe.
class MissionContents {
 public:
  using Position = Journal::Position;

  void NoteRecord(Position position, uint64_t bytes);
  // Features that come with the record at that position.
  void NoteFeatures(KeyframeId id, Position position, uint64_t bytes);
  // The record at that position removes the keyframe from the map. Its features are dropped with
  // the next snapshot.
  void NoteRemoved(KeyframeId id, Position position);
  // A snapshot stands for all records up to its position, and `dropped` have no features any more.
  void NoteSnapshot(Position position, uint64_t bytes, const std::vector<KeyframeId>& dropped);

  // Returns the keyframes whose features came before the snapshot and are not in it.
  std::vector<KeyframeId> FindUnneeded(const JournalSnapshot& snapshot) const;
  // Returns whether records since the last snapshot are larger than it and than `min_bytes`, or the
  // features of removed keyframes are as much (8 MiB are enough) and a quarter of all features.
  bool WantsSnapshot(uint64_t min_bytes) const;

  // Returns the position of the last snapshot; 0: there is none.
  Position snapshot_position() const { return snapshot_position_; }
  uint64_t live_bytes() const { return snapshot_bytes_ + record_bytes_ + feature_bytes_; }

 private:
  struct StoredFeatures {
    Position position = 0;
    uint64_t bytes = 0;
    Position removed_at = 0;  // 0: not removed.
  };

  // Takes back that it was removed.
  void Keep(StoredFeatures& stored);

  Position snapshot_position_ = 0;
  uint64_t snapshot_bytes_ = 0;
  std::map<Position, uint64_t> records_;  // Those since the snapshot.
  uint64_t record_bytes_ = 0;
  std::map<KeyframeId, StoredFeatures> features_;
  uint64_t feature_bytes_ = 0;
  uint64_t removed_bytes_ = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_MISSION_CONTENTS_H_
