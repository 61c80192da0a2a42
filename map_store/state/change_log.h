// Remembers what changed of a local map lately, so that others can be told without a look at all of
// it.
#ifndef CORBSLAM_MAP_STORE_STATE_CHANGE_LOG_H_
#define CORBSLAM_MAP_STORE_STATE_CHANGE_LOG_H_

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "slam/util/ids.h"

namespace corbslam::map_store {

struct ItemChanges {
  std::vector<KeyframeId> keyframes;  // Keyframes that came, moved or went.
  std::vector<KeyframeId> sights;  // Keyframes that see other points, or the same by other names.
  std::vector<MapPointId> points;  // Points that came or moved.
  std::vector<MapPointId> landmarks;  // Points that went, or belong to other landmarks now.

  size_t size() const {
    return keyframes.size() + sights.size() + points.size() + landmarks.size();
  }
};

// The latest changes of a local map, some times as many as it has items: who lags further behind
// had better look at all of it. It is a value and not thread-safe. It is not stored: after a
// restart nobody has been told anything.
class ChangeLog {
 public:
  // These note an item of the change that is under way.
  void NoteKeyframe(KeyframeId id) { open_.keyframes.push_back(id); }
  void NoteSights(KeyframeId id) { open_.sights.push_back(id); }
  void NotePoint(MapPointId id) { open_.points.push_back(id); }
  void NoteLandmark(MapPointId id) { open_.landmarks.push_back(id); }
  // Ends the change, which made the mission's state this version; the local map has so many
  // keyframes and points now.
  void Close(uint64_t version, size_t map_items);
  // Forgets all changes: up to this version anything may have changed.
  void Forget(uint64_t version);

  // Returns whether it remembers all that changed after `version`.
  bool Knows(uint64_t version) const { return version >= known_after_; }
  // Returns what changed after `version`, ascending, each item once; none when that is not known
  // any more.
  std::optional<ItemChanges> Since(uint64_t version) const;

  // Returns about how much of the heap it takes.
  uint64_t HeapBytes() const;

 private:
  struct Entry {
    uint64_t version = 0;
    ItemChanges changes;
  };

  ItemChanges open_;
  std::deque<Entry> entries_;
  size_t items_ = 0;  // Items in all entries.
  uint64_t known_after_ = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_CHANGE_LOG_H_
