// What changed of a local map lately, so that others can be told of it without a look at the whole.
#ifndef CORBSLAM_MAP_STORE_STATE_CHANGE_LOG_H_
#define CORBSLAM_MAP_STORE_STATE_CHANGE_LOG_H_

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "slam/util/ids.h"

namespace corbslam::map_store {

struct ItemChanges {
  std::vector<KeyframeId> keyframes;  // Came, moved or went.
  std::vector<KeyframeId> sights;     // See other points, or the same by other names.
  std::vector<MapPointId> points;     // Came or moved.
  std::vector<MapPointId> landmarks;  // Went, or belong to other landmarks.

  size_t size() const {
    return keyframes.size() + sights.size() + points.size() + landmarks.size();
  }
};

// A value; not thread-safe. Of the past it remembers as much as it has room for. Not stored: after
// a restart nobody has been told anything.
class ChangeLog {
 public:
  // Of the change that is under way.
  void NoteKeyframe(KeyframeId id) { open_.keyframes.push_back(id); }
  void NoteSights(KeyframeId id) { open_.sights.push_back(id); }
  void NotePoint(MapPointId id) { open_.points.push_back(id); }
  void NoteLandmark(MapPointId id) { open_.landmarks.push_back(id); }
  // It made the mission's state this version.
  void Close(uint64_t version);
  // Up to this version anything may have changed.
  void Forget(uint64_t version);

  // Whether it remembers all that changed after `version`.
  bool Knows(uint64_t version) const { return version >= known_after_; }
  // What changed after `version`, ascending, each once; none when that is not known any more.
  std::optional<ItemChanges> Since(uint64_t version) const;

 private:
  struct Entry {
    uint64_t version = 0;
    ItemChanges changes;
  };

  ItemChanges open_;
  std::deque<Entry> entries_;
  size_t items_ = 0;  // In all entries.
  uint64_t known_after_ = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_CHANGE_LOG_H_
