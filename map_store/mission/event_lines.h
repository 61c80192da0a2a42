// Says in the log what of a mission's events people watch for.
#ifndef CORBSLAM_MAP_STORE_MISSION_EVENT_LINES_H_
#define CORBSLAM_MAP_STORE_MISSION_EVENT_LINES_H_

#include <optional>
#include <string>

#include "map_store/state/mission_event.h"

namespace corbslam::map_store {

// Returns the line: maps that begin, robots that are lost, islands that become one. Nullopt for
// what others log (sessions, overlaps taken back) and for what happens all the time (overlaps,
// loops, adjustments).
std::optional<std::string> LineOf(const std::string& mission, const MissionEvent::What& what);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_MISSION_EVENT_LINES_H_
