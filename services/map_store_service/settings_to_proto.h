// Converts settings of robots, as their owner signed them, to the contract.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_SETTINGS_TO_PROTO_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_SETTINGS_TO_PROTO_H_

#include <vector>

#include "corbslam/v1/robot_settings.pb.h"
#include "map_store/state/mission_profile.h"

namespace corbslam::services {

v1::RobotSettingsList ToProto(const std::vector<map_store::SignedSettings>& settings);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_SETTINGS_TO_PROTO_H_
