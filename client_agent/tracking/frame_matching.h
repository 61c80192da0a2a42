// The three ways in which a frame finds its first map points.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_MATCHING_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_MATCHING_H_

#include <vector>

#include "client_agent/tracking/frame.h"
#include "client_agent/tracking/local_map_view.h"

namespace corbslam::client_agent {

// Each replaces frame.associations or adds to them, and returns how many there are (were added).

// Looks for what `previous` sees around where `predicted_camera_from_map` has it.
int MatchPreviousFrame(const Frame& previous, const Rigid3d& predicted_camera_from_map,
                       double radius_px, Frame& frame);

// Looks for what `keyframe` sees, by words; both need them.
int MatchKeyframe(const Map& map, const Keyframe& keyframe, Frame& frame);

// Adds points of the local map in view of the frame's pose that it does not see yet. `widening`
// multiplies the search radius. `visible` gets the ids of the points in view.
int MatchLocalPoints(const std::vector<PointInView>& points, double widening, Frame& frame,
                     std::vector<MapPointId>& visible);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_FRAME_MATCHING_H_
