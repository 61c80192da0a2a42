// Whether what the robot itself saw says where another robot's keyframe lies.
#ifndef CORBSLAM_CLIENT_AGENT_MEMORY_VISUAL_CONTACT_H_
#define CORBSLAM_CLIENT_AGENT_MEMORY_VISUAL_CONTACT_H_

#include "slam/map/map.h"

namespace corbslam {

// The own keyframe that shares the most points with the foreign one, if they are enough to hold the
// two together; else invalid.
KeyframeId MostSharing(const Keyframe& foreign, LocalMapId own);

// Most points that the two share project to where each of the two saw them, as `map` has them.
bool AgreeOnSharedPoints(const Map& map, const Keyframe& foreign, const Keyframe& own);

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_MEMORY_VISUAL_CONTACT_H_
