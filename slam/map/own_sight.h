// Tells which points one local map's keyframes locate by themselves.
#ifndef CORBSLAM_SLAM_MAP_OWN_SIGHT_H_
#define CORBSLAM_SLAM_MAP_OWN_SIGHT_H_

#include <iterator>

#include "slam/map/map.h"

namespace corbslam {

// Returns whether the point is located by `local_map`: two of its keyframes see it, from which
// follows where it is, whatever anybody else says. Costs a search among its observations.
inline bool IsLocatedBy(LocalMapId local_map, const MapPoint& point) {
  const auto first = point.observations.lower_bound({local_map, 0});
  if (first == point.observations.end() || first->first.local_map != local_map) return false;
  const auto second = std::next(first);
  return second != point.observations.end() && second->first.local_map == local_map;
}

// Does what Map::ReplacePoint does. Where `local_map` locates the replaced point, and not a
// survivor that others made, the survivor stands where the replaced one did.
inline bool ReplaceWithSight(LocalMapId local_map, MapPointId replaced, MapPointId survivor,
                             Map& map) {
  const MapPoint* from = map.FindPoint(replaced);
  const MapPoint* to = map.FindPoint(survivor);
  if (from == nullptr || to == nullptr) return false;
  const bool knows_better = survivor.local_map != local_map && IsLocatedBy(local_map, *from) &&
                            !IsLocatedBy(local_map, *to);
  if (knows_better) map.SetPosition(survivor, from->position_in_map);
  return map.ReplacePoint(replaced, survivor);
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MAP_OWN_SIGHT_H_
