#include "services/client/remote/place_asker.h"

#include <chrono>
#include <utility>

#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/convert/features.h"
#include "services/convert/geometry.h"
#include "services/convert/resource_names.h"
#include "services/convert/status.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr std::chrono::seconds kPatience{2};

v1::LocalizeRequest MakeRequest(const std::string& mission, const KeyframePayload& frame) {
  v1::LocalizeRequest request;
  request.set_mission(MissionName(mission));
  ToProto(*frame.camera, request.mutable_features()->mutable_camera());
  // A store that looks places up reads coded features, too.
  v1::KeyframePayload payload;
  ToProto(frame, &payload, FeatureForm::kCoded);
  *request.mutable_features()->mutable_features() = std::move(*payload.mutable_features());
  return request;
}

absl::StatusOr<std::optional<Rigid3d>> Ask(v1::MapStore::Stub& stub, const std::string& mission,
                                           const KeyframePayload& frame) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  v1::LocalizeResponse answer;
  RETURN_IF_ERROR(FromGrpcStatus(stub.Localize(&context, MakeRequest(mission, frame), &answer)));
  const bool is_found = answer.stage() == v1::LOCATE_STAGE_LOCATED && answer.in_global_frame();
  if (!is_found) return std::nullopt;
  ASSIGN_OR_RETURN(const Rigid3d camera_from_global, FromProto(answer.camera_from_island()));
  return camera_from_global;
}

}  // namespace

std::function<absl::StatusOr<std::optional<Rigid3d>>(const KeyframePayload& frame)> MakePlaceAsker(
    std::shared_ptr<StoreRoute> route, const std::string& mission) {
  return [route = std::move(route),
          mission](const KeyframePayload& frame) -> absl::StatusOr<std::optional<Rigid3d>> {
    absl::StatusOr<std::optional<Rigid3d>> answer;
    RETURN_IF_ERROR(route->Ask([&](v1::MapStore::Stub& store) {
      answer = Ask(store, mission, frame);
      return answer.status();
    }));
    return answer;
  };
}

}  // namespace corbslam::services
