// Converts changes of the map to messages for those who watch it.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_MAP_CHANGES_TO_PROTO_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_MAP_CHANGES_TO_PROTO_H_

#include <vector>

#include "corbslam/v1/map_store_service.pb.h"
#include "map_store/state/lookups.h"

namespace corbslam::services {

// Returns one or more messages, which are the parts of one change.
std::vector<v1::WatchMapResponse> ToProto(const map_store::MapChanges& changes);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_MAP_CHANGES_TO_PROTO_H_
