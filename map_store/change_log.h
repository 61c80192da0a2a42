// What changed of a local map lately, so that others can be told of it without a look at the whole.
#ifndef CORBSLAM_MAP_STORE_CHANGE_LOG_H_
#define CORBSLAM_MAP_STORE_CHANGE_LOG_H_

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "slam/util/ids.h"

namespace corbslam::map_store {

// Ascending, each once.
struct ItemChanges {
  std::vector<KeyframeId> keyframes;
  std::vector<MapPointId> points;
};

// A value; not thread-safe. Of the past it remembers as much as it has room for. Not stored: after
// a restart nobody has been told anything.
class ChangeLog {
 public:
  // Of the change that is under way.
  void Note(KeyframeId id) { open_.keyframes.push_back(id); }
  void Note(MapPointId id) { open_.points.push_back(id); }
  // It made the mission's state this version.
  void Close(uint64_t version);
  // Up to this version anything may have changed.
  void Forget(uint64_t version);

  // What changed after `version`, as far as that is known: none when it is not.
  std::optional<ItemChanges> Since(uint64_t version) const;

 private:
  struct Entry {
    uint64_t version = 0;
    ItemChanges changes;

    size_t size() const { return changes.keyframes.size() + changes.points.size(); }
  };

  ItemChanges open_;
  std::deque<Entry> entries_;
  size_t items_ = 0;  // In all entries.
  uint64_t known_after_ = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_CHANGE_LOG_H_
