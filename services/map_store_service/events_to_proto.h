// Converts events to messages for those who watch them.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_EVENTS_TO_PROTO_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_EVENTS_TO_PROTO_H_

#include "absl/strings/string_view.h"
#include "corbslam/v1/events.pb.h"
#include "map_store/state/mission_event.h"

namespace corbslam::services {

// `proto` is empty.
void ToProto(absl::string_view mission, const map_store::MissionEvent& event,
             v1::MissionEvent* proto);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_EVENTS_TO_PROTO_H_
