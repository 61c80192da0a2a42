#include "services/map_store_service/localize_convert.h"

#include <algorithm>
#include <utility>

#include "services/convert/errors.h"
#include "services/convert/geometry.h"
#include "services/convert/resource_names.h"
#include "services/convert/work/locate_frame.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

using map_store::LocalizeQuery;
using map_store::PosePrior;

constexpr double kMaxRadius_m = 1e6;

absl::StatusOr<PosePrior> FromProto(const v1::PosePrior& proto) {
  PosePrior prior;
  absl::StatusOr<Rigid3d> pose = services::FromProto(proto.camera_from_global());
  RETURN_IF_ERROR(Locate(pose.status(), "prior.camera_from_global"));
  prior.camera_from_global = *pose;
  if (!(proto.radius_m() > 0 && proto.radius_m() <= kMaxRadius_m)) {
    return absl::InvalidArgumentError(absl::StrCat("prior.radius_m is ", proto.radius_m(),
                                                   ", must be above 0 and at most ", kMaxRadius_m));
  }
  prior.radius_m = proto.radius_m();
  return prior;
}

uint32_t Count(int value) { return static_cast<uint32_t>(std::max(value, 0)); }

}  // namespace

absl::StatusOr<LocalizeQuery> LocalizeQueryFromProto(const v1::LocalizeRequest& request) {
  LocalizeQuery query;
  if (request.has_picture()) {
    ASSIGN_OR_RETURN(query.picture, services::FromProto(request.picture()));
  } else if (request.has_features()) {
    absl::StatusOr<Keyframe> frame =
        FrameFromProto(request.features().camera(), request.features().features());
    RETURN_IF_ERROR(Locate(frame.status(), "features"));
    query.picture = *std::move(frame);
  } else {
    return absl::InvalidArgumentError("the request has neither a picture nor features");
  }
  if (request.has_prior()) {
    ASSIGN_OR_RETURN(query.prior, FromProto(request.prior()));
  }
  query.all_islands = request.all_islands();
  return query;
}

void ToProto(const std::string& mission, const map_store::LocalizeAnswer& answer,
             v1::LocalizeResponse* response) {
  response->set_stage(ToProto(answer.stage));
  response->set_revision(answer.revision);
  response->set_word_matches(Count(answer.word_matches));
  response->set_pose_inliers(Count(answer.pose_inliers));
  response->set_inliers(Count(answer.inliers));
  response->set_inliers_needed(Count(answer.inliers_needed));
  response->set_visible_points(Count(answer.visible_points));
  response->set_chance_inliers(Count(answer.chance_inliers));
  if (answer.fitting_camera.has_value()) {
    ToProto(*answer.fitting_camera, response->mutable_fitting_camera());
  }
  if (answer.stage != LocateStage::kLocated) return;
  response->set_island(LocalMapName(mission, answer.island));
  response->set_in_global_frame(answer.in_reference_island);
  ToProto(answer.camera_from_island, response->mutable_camera_from_island());
  ToProto(answer.covariance, response->mutable_covariance());
  for (const KeyframeId& id : answer.keyframes) response->add_keyframes(KeyframeName(mission, id));
}

}  // namespace corbslam::services
