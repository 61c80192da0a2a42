// Finds what a tracked frame adds to what the newest keyframes measured.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_MEASUREMENTS_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_MEASUREMENTS_H_

#include <vector>

#include "client_agent/mapping/measurement_book.h"
#include "client_agent/tracking/frame.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

// Returns a measurement for each map point that the frame sees, of the newest keyframe of `own`
// that sees the point, if that keyframe is provisional and noise explains the difference (95 %).
// There are none where the frame's reference is not in the map.
std::vector<KeypointMeasurement> FindMeasurements(const Map& map, LocalMapId own,
                                                  const Frame& frame);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_MEASUREMENTS_H_
