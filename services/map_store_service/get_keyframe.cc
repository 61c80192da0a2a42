#include <utility>

#include "services/convert/features.h"
#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::KeyframeInfo;

grpc::ServerUnaryReactor* MapStoreService::GetKeyframe(grpc::CallbackServerContext* context,
                                                       const v1::GetKeyframeRequest* request,
                                                       v1::Keyframe* response) {
  return AnswerOn(pool_, context, [this, request, response]() -> absl::Status {
    if (!v1::KeyframeView_IsValid(request->view())) {
      return absl::InvalidArgumentError(
          absl::StrCat("view is ", static_cast<int>(request->view()), ", must be 0 to 3"));
    }
    ASSIGN_OR_RETURN(const KeyframePath path, ParseKeyframeName(request->name()));
    if (request->view() == v1::KEYFRAME_VIEW_PICTURE) {
      ASSIGN_OR_RETURN(auto picture, store_.GetPicture(path.mission, path.keyframe));
      if (picture.has_value()) {
        response->set_picture(std::move(picture->jpeg));
        response->set_picture_scale(picture->scale);
      }
    }
    const bool is_full = request->view() == v1::KEYFRAME_VIEW_FULL;
    ASSIGN_OR_RETURN(const KeyframeInfo info,
                     store_.GetKeyframe(path.mission, path.keyframe, /*with_sights=*/is_full));
    ToProto(path.mission, info, response);
    if (is_full) {
      ToProto(*info.payload, response->mutable_payload());
      for (const auto& [keypoint, point] : info.sights) {
        v1::Sight* const sight = response->add_sights();
        sight->set_keypoint(keypoint);
        sight->set_local_map(point.local_map.value);
        sight->set_point(point.index);
      }
    }
    return absl::OkStatus();
  });
}

}  // namespace corbslam::services
