// Places islands that nothing connects side by side, so that they can be told apart.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_ISLAND_LAYOUT_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_ISLAND_LAYOUT_H_

#include <Eigen/Core>
#include <map>

#include "services/client/store/told_map.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// Returns mission_from_island of each island, a translation: none for the one in the global frame,
// and for the others, in the order of their names, as far along x that their keyframes stand clear
// of those before. Their distances mean nothing.
std::map<LocalMapId, Eigen::Vector3d> PlaceIslands(const ToldMap::Islands& islands);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_ISLAND_LAYOUT_H_
