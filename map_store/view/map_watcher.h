// Remembers what a watcher of a mission's map has seen of it, and finds what is new.
#ifndef CORBSLAM_MAP_STORE_VIEW_MAP_WATCHER_H_
#define CORBSLAM_MAP_STORE_VIEW_MAP_WATCHER_H_

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "map_store/state/lookups.h"
#include "map_store/state/mission_state.h"
#include "map_store/view/placement.h"

namespace corbslam::map_store {

// What one watcher has seen of one mission. A value; not thread-safe. It remembers which local maps
// were seen in which islands, not what was in them: that follows from versions. Its cost is that of
// what changed and, at each change, a look at the pose table of the local maps that changed.
class MapWatcher {
 public:
  // `from_version` is the MapChanges::version of another watcher of the same store: islands that
  // have not changed since are left out. 0: the watcher knows nothing.
  MapWatcher(uint64_t from_version, bool include_points)
      : include_points_(include_points), version_(from_version) {}

  // Returns the next piece, about `max_items` keyframes and points; none if nothing is new. What
  // changes while a change is told in pieces comes with the next change at the latest. The state
  // must always be of the same mission.
  std::optional<MapChanges> Next(const MissionState& state, size_t max_items);

 private:
  // One local map's part of the change that is being told.
  struct Part {
    LocalMapId local_map;
    IslandId island;
    bool whole = false;
    uint64_t since = 0;
    // Ids at which the part goes on.
    KeyframeId next_keyframe;
    bool points_begun = false;
    MapPointId next_point;
    // The items that are to be looked at, if the part is not of the whole local map.
    std::set<KeyframeId> keyframes;
    std::set<MapPointId> points;
    bool fusion_moved_points = false;
  };

  void Begin(const MissionState& state, MapChanges& changes);
  void BeginIsland(const MissionState& state, const Island& island, MapChanges& changes);
  // Returns false if what the watcher knows of the island can't be brought up to date.
  bool CanUpdate(const MissionState& state, const Island& island) const;
  std::optional<Part> MakePart(const MissionState& state, LocalMapId local_map, IslandId island,
                               bool anew) const;
  // Both return whether the part has no more of them.
  bool TakeKeyframes(const MissionState& state, Part& part, size_t& room,
                     MapChanges::Island& changes);
  bool TakePoints(const MissionState& state, Part& part, size_t& room, MapChanges::Island& changes);

  bool include_points_;
  uint64_t version_;
  uint64_t revision_ = 0;
  bool begun_ = false;
  std::map<LocalMapId, IslandId> seen_;
  std::set<IslandId> islands_;
  // How many points may still be looked at for the piece that is being made.
  size_t steps_ = 0;
  // The change that is being told.
  uint64_t version_of_change_ = 0;
  uint64_t revision_of_change_ = 0;
  std::deque<Part> parts_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_VIEW_MAP_WATCHER_H_
