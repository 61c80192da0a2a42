// Describes for people what happened in a mission.
#ifndef CORBSLAM_SERVICES_TOOL_MISSION_EVENT_TEXT_H_
#define CORBSLAM_SERVICES_TOOL_MISSION_EVENT_TEXT_H_

#include <string>

#include "corbslam/v1/events.pb.h"
#include "corbslam/v1/resources.pb.h"
#include "services/client/store/local_map_names.h"

namespace corbslam::services {

// Returns text such as "alpha/1 and bravo/1 are one island (340 ms)". A local map without a short
// name is called by its id.
std::string DescribeEvent(const v1::MissionEvent& event, const LocalMapNames& names);

// Returns text such as "1.40 % smaller than what its camera measures (+-0.16 %)".
std::string DescribeContradiction(const v1::MapContradiction& found);

// Returns whether somebody should look at it: tracking was lost, a map is not as another robot
// measures it, or overlaps were taken back.
bool IsWarning(const v1::MissionEvent& event);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_MISSION_EVENT_TEXT_H_
