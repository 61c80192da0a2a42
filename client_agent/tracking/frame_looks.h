// What a tracked frame adds to what the newest keyframes measured.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_LOOKS_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_LOOKS_H_

#include <vector>

#include "client_agent/mapping/look_book.h"
#include "client_agent/tracking/frame.h"
#include "slam/map/map.h"

namespace corbslam {

// A look at the newest keyframe of `own` that sees it, of each map point that the frame sees, where
// that keyframe is provisional and noise explains the difference (95 %). None where the frame's
// reference is not in the map.
std::vector<Look> FindLooks(const Map& map, LocalMapId own, const Frame& frame);

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_LOOKS_H_
