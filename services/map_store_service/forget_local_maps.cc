#include <glog/logging.h>

#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/observe/logging/log_fields.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

map_store::ForgetRequest FromProto(const std::string& agent,
                                   const v1::ForgetLocalMapsRequest& proto) {
  map_store::ForgetRequest request;
  request.agent = agent;
  if (proto.has_before_ns()) request.before_ns = proto.before_ns();
  if (proto.has_keep()) request.keep = proto.keep();
  request.dry_run = proto.dry_run();
  return request;
}

void ForgottenToProto(const map_store::ForgottenLocalMaps& forgotten,
                      v1::ForgetLocalMapsResponse* proto) {
  for (const LocalMapId& id : forgotten.local_maps) proto->add_local_maps(ToString(id));
  for (const uint64_t number : forgotten.numbers) {
    proto->add_numbers(static_cast<uint32_t>(number));
  }
  proto->set_parts(forgotten.parts);
  proto->set_keyframes(forgotten.keyframes);
  proto->set_map_points(forgotten.map_points);
  proto->set_stored_bytes(forgotten.stored_bytes);
}

}  // namespace

absl::Status MapStoreService::ForgetLocalMaps(const v1::ForgetLocalMapsRequest& request,
                                              v1::ForgetLocalMapsResponse* response) {
  ASSIGN_OR_RETURN(const AgentPath path, ParseAgentName(request.parent(), false));
  ASSIGN_OR_RETURN(const map_store::ForgottenLocalMaps forgotten,
                   store_.ForgetLocalMaps(path.mission, FromProto(path.agent, request)));
  ForgottenToProto(forgotten, response);
  LOG(INFO) << LogFields{.mission = path.mission}
            << (request.dry_run() ? "local maps that would be deleted of agent "
                                  : "local maps deleted of agent ")
            << path.agent << ": " << forgotten.local_maps.size();
  return absl::OkStatus();
}

}  // namespace corbslam::services
