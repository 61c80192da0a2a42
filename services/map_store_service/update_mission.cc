#include <glog/logging.h>

#include <optional>
#include <vector>

#include "absl/strings/str_join.h"
#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/profile_convert.h"
#include "services/observe/logging/log_fields.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MissionInfo;
using map_store::ProfileField;

grpc::ServerUnaryReactor* MapStoreService::UpdateMission(grpc::CallbackServerContext* context,
                                                         const v1::UpdateMissionRequest* request,
                                                         v1::Mission* response) {
  return AnswerOn(pool_, context, [this, request, response]() -> absl::Status {
    ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request->mission().name()));
    ASSIGN_OR_RETURN(const std::vector<ProfileField> fields,
                     FieldsFromProto(request->update_mask()));
    RETURN_IF_ERROR(CheckAskedLimits(request->mission(), fields));
    std::optional<uint64_t> expected;
    if (request->has_expected_revision()) expected = request->expected_revision();
    RETURN_IF_ERROR(
        store_.UpdateMission(mission, ProfileFromProto(request->mission()), fields, expected));
    LOG(INFO) << LogFields{.mission = mission}
              << "mission changed: " << absl::StrJoin(request->update_mask().paths(), ", ");
    ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(mission));
    ToProto(info, response);
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
