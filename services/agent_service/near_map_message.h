// Converts a part of a robot's local map to and from the wire.
#ifndef CORBSLAM_SERVICES_AGENT_SERVICE_NEAR_MAP_MESSAGE_H_
#define CORBSLAM_SERVICES_AGENT_SERVICE_NEAR_MAP_MESSAGE_H_

#include "absl/status/statusor.h"
#include "client_agent/map/near_map.h"
#include "corbslam/v1/agent_service.pb.h"

namespace corbslam::services {

void ToProto(const client_agent::NearMap& near, v1::WatchAgentMapResponse* proto);
// INVALID_ARGUMENT names the field: an id or a pose that is none, or coordinates that are not three
// finite numbers each.
absl::StatusOr<client_agent::NearMap> FromProto(const v1::WatchAgentMapResponse& proto);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_AGENT_SERVICE_NEAR_MAP_MESSAGE_H_
