// Makes the part of the map that a correction of the robot's own map works on.
#ifndef CORBSLAM_CLIENT_AGENT_LOOP_CLOSING_CORRECTION_VIEW_H_
#define CORBSLAM_CLIENT_AGENT_LOOP_CLOSING_CORRECTION_VIEW_H_

#include <optional>

#include "slam/map/map.h"

namespace corbslam::client_agent {

// Returns a copy of all that is own with all that it sees, and of what others made that own loops
// end at: the candidate of a loop about to be closed, the ends of earlier loop edges, as many of
// their best covisible keyframes as welding looks at, and what those see. Others' keyframes
// elsewhere are left out: they lie in the own map where that is now, drift and all, and must not
// hold the drift there. Points of others that only own keyframes of the copy see refer to one of
// those.
Map CorrectionView(const Map& map, LocalMapId own, const std::optional<KeyframeId>& candidate);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_LOOP_CLOSING_CORRECTION_VIEW_H_
