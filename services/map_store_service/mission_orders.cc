#include <glog/logging.h>

#include <optional>
#include <vector>

#include "absl/strings/str_join.h"
#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/profile_convert.h"
#include "services/observe/logging/log_fields.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MissionInfo;
using map_store::ProfileField;

absl::Status MapStoreService::CreateMission(const v1::CreateMissionRequest& request,
                                            v1::Mission* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.mission().name()));
  RETURN_IF_ERROR(CheckAskedLimits(
      request.mission(), {map_store::ProfileField::kLimits, map_store::ProfileField::kAgentLimits,
                          map_store::ProfileField::kRetention}));
  RETURN_IF_ERROR(store_.CreateMission(mission, ProfileFromProto(request.mission())));
  ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(mission));
  LOG(INFO) << LogFields{.mission = mission} << "mission created, uid " << info.uid;
  ToProto(info, response);
  return absl::OkStatus();
}

absl::Status MapStoreService::UpdateMission(const v1::UpdateMissionRequest& request,
                                            v1::Mission* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.mission().name()));
  ASSIGN_OR_RETURN(const std::vector<ProfileField> fields, FieldsFromProto(request.update_mask()));
  RETURN_IF_ERROR(CheckAskedLimits(request.mission(), fields));
  std::optional<uint64_t> expected;
  if (request.has_expected_revision()) expected = request.expected_revision();
  RETURN_IF_ERROR(
      store_.UpdateMission(mission, ProfileFromProto(request.mission()), fields, expected));
  LOG(INFO) << LogFields{.mission = mission}
            << "mission changed: " << absl::StrJoin(request.update_mask().paths(), ", ");
  ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(mission));
  ToProto(info, response);
  return absl::OkStatus();
}

absl::Status MapStoreService::SleepMission(const v1::SleepMissionRequest& request,
                                           v1::Mission* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.name()));
  RETURN_IF_ERROR(store_.SleepMission(mission));
  LOG(INFO) << LogFields{.mission = mission} << "mission put to sleep";
  ASSIGN_OR_RETURN(const map_store::MissionInfo info, store_.GetMission(mission));
  ToProto(info, response);
  return absl::OkStatus();
}

absl::Status MapStoreService::DeleteMission(const v1::DeleteMissionRequest& request,
                                            v1::DeleteMissionResponse* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.name()));
  ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(mission));
  RETURN_IF_ERROR(store_.DeleteMission(mission, request.uid()));
  LOG(INFO) << LogFields{.mission = mission} << "mission deleted, uid " << info.uid;
  response->set_local_maps(static_cast<uint32_t>(info.local_maps));
  return absl::OkStatus();
}

absl::Status MapStoreService::AskForExactPlaces(const v1::AskForExactPlacesRequest& request,
                                                v1::AskForExactPlacesResponse*) {
  ASSIGN_OR_RETURN(const AgentPath path, ParseAgentName(request.name(), /*may_be_all=*/false));
  return store_.AskForExactPlaces(path.mission, path.agent);
}

absl::Status MapStoreService::RetractOverlap(const v1::RetractOverlapRequest& request,
                                             v1::RetractOverlapResponse* response) {
  ASSIGN_OR_RETURN(const OverlapPath path, ParseOverlapName(request.name()));
  ASSIGN_OR_RETURN(const std::vector<uint64_t> taken_back,
                   store_.RetractOverlap(path.mission, path.overlap, request.keep_apart()));
  LOG(INFO) << LogFields{.mission = path.mission} << "overlaps taken back: " << taken_back.size()
            << ", " << path.overlap << " among them";
  for (const uint64_t overlap : taken_back) {
    response->add_overlaps(OverlapName(path.mission, overlap));
  }
  return absl::OkStatus();
}

absl::Status MapStoreService::RederiveGlobalLayer(const v1::RederiveGlobalLayerRequest& request,
                                                  v1::RederiveGlobalLayerResponse*) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.name()));
  RETURN_IF_ERROR(store_.RederiveGlobalLayer(mission));
  LOG(INFO) << LogFields{.mission = mission} << "fusion begins afresh";
  return absl::OkStatus();
}

}  // namespace corbslam::services
