// Knows which overlaps join the local maps of an island, as keyframes that hold them go.
#ifndef CORBSLAM_MAP_STORE_RETIRING_SESSION_LINKS_H_
#define CORBSLAM_MAP_STORE_RETIRING_SESSION_LINKS_H_

#include <cstddef>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// A value; not thread-safe.
class SessionLinks {
 public:
  using Overlaps = std::vector<std::pair<KeyframeId, KeyframeId>>;

  explicit SessionLinks(Overlaps overlaps);

  // Returns whether an overlap that is left is the keyframe's.
  bool Holds(KeyframeId id) const { return count_.contains(id); }
  // Returns whether without the keyframe's overlaps local maps would fall apart that the others
  // hold together.
  bool IsNeeded(KeyframeId id) const;
  // The caller says that the keyframe goes, and its overlaps with it.
  void Cut(KeyframeId id);

 private:
  // Counts the groups of local maps that are joined without the keyframe's overlaps (invalid: with
  // all).
  size_t CountGroups(KeyframeId without) const;

  Overlaps overlaps_;
  absl::flat_hash_map<KeyframeId, size_t> count_;  // Overlaps of each keyframe that holds some.
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RETIRING_SESSION_LINKS_H_
