#include "map_store/retiring/session_links.h"

#include <map>

namespace corbslam::map_store {
namespace {

// Joins local maps into groups.
class Groups {
 public:
  void Add(LocalMapId id) { parents_.try_emplace(id, id); }
  void Join(LocalMapId a, LocalMapId b) { parents_.at(Find(a)) = Find(b); }
  size_t Count() const {
    size_t count = 0;
    for (const auto& [id, parent] : parents_) count += id == parent;
    return count;
  }

 private:
  LocalMapId Find(LocalMapId id) {
    while (parents_.at(id) != id) {
      LocalMapId& parent = parents_.at(id);
      parent = parents_.at(parent);
      id = parent;
    }
    return id;
  }

  std::map<LocalMapId, LocalMapId> parents_;
};

}  // namespace

SessionLinks::SessionLinks(Overlaps overlaps) : overlaps_(std::move(overlaps)) {
  for (const auto& [a, b] : overlaps_) {
    ++count_[a];
    ++count_[b];
  }
}

bool SessionLinks::IsNeeded(KeyframeId id) const {
  return Holds(id) && CountGroups(id) > CountGroups(KeyframeId());
}

void SessionLinks::Cut(KeyframeId id) {
  if (!Holds(id)) return;
  std::erase_if(overlaps_, [this, id](const auto& overlap) {
    if (overlap.first != id && overlap.second != id) return false;
    for (const KeyframeId& end : {overlap.first, overlap.second}) {
      if (--count_.at(end) == 0) count_.erase(end);
    }
    return true;
  });
}

size_t SessionLinks::CountGroups(KeyframeId without) const {
  Groups groups;
  for (const auto& [a, b] : overlaps_) {
    groups.Add(a.local_map);
    groups.Add(b.local_map);
    if (a != without && b != without) groups.Join(a.local_map, b.local_map);
  }
  return groups.Count();
}

}  // namespace corbslam::map_store
