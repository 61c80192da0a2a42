// Writes a mission as JSON, for scripts; the fields are those of corbslam.v1.Mission.
#ifndef CORBSLAM_SERVICES_TOOL_MISSION_MISSION_JSON_H_
#define CORBSLAM_SERVICES_TOOL_MISSION_MISSION_JSON_H_

#include <nlohmann/json.hpp>

#include "corbslam/v1/resources.pb.h"

namespace corbslam::services {

nlohmann::ordered_json ToJson(const v1::Mission& mission);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_MISSION_MISSION_JSON_H_
