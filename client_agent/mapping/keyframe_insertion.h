// Puts a frame that tracking chose into the map.
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_KEYFRAME_INSERTION_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_KEYFRAME_INSERTION_H_

#include <functional>
#include <vector>

#include "client_agent/map/guarded_map.h"
#include "client_agent/mapping/mapping_queue.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

// Adds the keyframe, the observations that tracking found, and points for its close keypoints that
// see none (ORB-SLAM2, T-RO 2017); of a map that begins both keyframes and all that they see.
// Returns the new points that are on probation: those that a map begins with are not. Mapping
// thread only; writes.
std::vector<MapPointId> InsertKeyframe(const NewKeyframe& keyframe, GuardedMap& map);

// Counts an observation twice where it has depth (ORB-SLAM2).
int CountObservations(const Map& map, const MapPoint& point);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_KEYFRAME_INSERTION_H_
