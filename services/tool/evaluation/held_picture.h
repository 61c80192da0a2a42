// Composes pictures of what one robot holds of the map: the paper's figure 5.
#ifndef CORBSLAM_SERVICES_TOOL_EVALUATION_HELD_PICTURE_H_
#define CORBSLAM_SERVICES_TOOL_EVALUATION_HELD_PICTURE_H_

#include <optional>
#include <string>

#include "client_agent/map/near_map.h"
#include "services/client/store/served_mission.h"
#include "slam/rendering/map_picture.h"

namespace corbslam::services {

// Returns a picture in the frame of the robot's local map, with the robot as the own one. `map`
// says only who the others are, and who is whose parent: an edge joins keyframes that the robot
// holds. Keyframes of somebody whom it doesn't know are "another robot"'s.
MapPicture ComposeHeldPicture(const std::string& robot, const client_agent::NearMap& held,
                              const ServedMap& map);

// Returns the part around the own keyframe that has the most of others' keyframes near it, within a
// seventh of the diagonal of the box that all keyframes lie in. Nullopt where there are no own
// keyframes or none of others', and where less than a hundredth of the points lies there, as with a
// camera that hardly moves in a room.
std::optional<MapPicture> CutMeeting(const MapPicture& held);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_HELD_PICTURE_H_
