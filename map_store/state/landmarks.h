// Says which map points are one landmark. A landmark is named by its survivor.
#ifndef CORBSLAM_MAP_STORE_STATE_LANDMARKS_H_
#define CORBSLAM_MAP_STORE_STATE_LANDMARKS_H_

#include <cstdint>
#include <map>
#include <set>

#include "absl/container/flat_hash_map.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// The sets of points that are landmarks. A value; not thread-safe. Points that belong to no set are
// their own survivors.
class Landmarks {
 public:
  using Sets = std::map<MapPointId, std::set<MapPointId>>;

  // Returns each survivor's other members, of which there is at least one.
  const Sets& sets() const { return members_; }
  MapPointId Survivor(MapPointId point) const;
  // Returns about how much of the heap it takes.
  uint64_t HeapBytes() const;

  // Joins the sets of both points. The survivor of `survivor`'s set stays and is returned.
  MapPointId Merge(MapPointId survivor, MapPointId member);
  // The caller says that the owner deleted the point. If it was the survivor, the member of the
  // least id is elected. Returns the survivor of what is left of the set; invalid if nothing is.
  MapPointId Remove(MapPointId point);
  // The caller says that the owner replaced the point by another, which takes its place in the set.
  // Returns the survivor of the set.
  MapPointId Replace(MapPointId replaced, MapPointId by);
  // Forgets the sets that have a point of one of the local maps.
  void Dissolve(const std::set<LocalMapId>& local_maps);

 private:
  Sets members_;
  // The survivor of each member. It is only looked up, never walked through.
  absl::flat_hash_map<MapPointId, MapPointId> survivor_of_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STATE_LANDMARKS_H_
