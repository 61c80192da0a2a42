#include "services/security/guarded_map_store.h"

#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "services/convert/resource_names.h"
#include "services/convert/status.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

absl::StatusOr<std::string> MissionOf(absl::string_view name) {
  const std::vector<absl::string_view> parts = absl::StrSplit(name, '/');
  if (parts.size() < 2 || parts[0] != "missions") {
    return absl::InvalidArgumentError(absl::StrCat("name is \"",
                                                   absl::CHexEscape(name.substr(0, 200)),
                                                   "\", must begin with missions/{mission}"));
  }
  RETURN_IF_ERROR(CheckNameSegment("mission", parts[1]));
  return std::string(parts[1]);
}

grpc::ServerUnaryReactor* Refuse(grpc::CallbackServerContext* context, const absl::Status& why) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(ToGrpcStatus(why));
  return reactor;
}

// A stream that ends with an error and deletes itself.
template <typename Response>
class RefusedStream : public grpc::ServerWriteReactor<Response> {
 public:
  explicit RefusedStream(const absl::Status& why) { this->Finish(ToGrpcStatus(why)); }
  void OnDone() override { delete this; }
};

}  // namespace

SessionCheck MakeSessionCheck(std::shared_ptr<const AccessControl> access) {
  if (access == nullptr) return nullptr;
  return [access = std::move(access)](const grpc::CallbackServerContext& context,
                                      const std::string& mission, const std::string& agent) {
    return access->Check({Action::kUpload, mission, agent}, EvidenceOf(context), absl::Now());
  };
}

RestoreCheck MakeRestoreCheck(std::shared_ptr<const AccessControl> access) {
  if (access == nullptr) return nullptr;
  return [access = std::move(access)](const grpc::CallbackServerContext& context,
                                      const std::string& mission) {
    return access->Check({Action::kAdminister, mission, std::nullopt}, EvidenceOf(context),
                         absl::Now());
  };
}

LookCheck MakeLookCheck(std::shared_ptr<const AccessControl> access) {
  if (access == nullptr) return nullptr;
  return [access = std::move(access)](const grpc::CallbackServerContext& context,
                                      const std::string& name) -> absl::Status {
    ASSIGN_OR_RETURN(const std::string mission, MissionOf(name));
    return access->Check({Action::kLook, mission, std::nullopt}, EvidenceOf(context), absl::Now());
  };
}

StayCheckMaker MakeStayCheck(std::shared_ptr<const AccessControl> access) {
  if (access == nullptr) return nullptr;
  return [access = std::move(access)](const grpc::CallbackServerContext& context) -> StayCheck {
    const absl::StatusOr<Identity> identity = access->Identify(EvidenceOf(context), absl::Now());
    if (!identity.ok()) return [why = identity.status()] { return why; };
    return [access, caller = *identity] { return access->CheckNotRevoked(caller); };
  };
}

ListFilterMaker MakeListFilter(std::shared_ptr<const AccessControl> access) {
  if (access == nullptr) return nullptr;
  return [access = std::move(access)](const grpc::CallbackServerContext& context) -> ListFilter {
    const absl::StatusOr<Identity> identity = access->Identify(EvidenceOf(context), absl::Now());
    return [caller = identity.value_or(Identity())](const std::string& mission) {
      return Authorise(caller, {Action::kLook, mission, std::nullopt}).ok();
    };
  };
}

CallerNamer MakeCallerNamer(std::shared_ptr<const AccessControl> access) {
  if (access == nullptr) return nullptr;
  return [access = std::move(access)](const grpc::CallbackServerContext& context) {
    const absl::StatusOr<Identity> identity = access->Identify(EvidenceOf(context), absl::Now());
    if (!identity.ok()) return std::string();
    const std::string token =
        identity->token_id.empty() ? "" : absl::StrCat(" (token ", identity->token_id, ")");
    return absl::StrCat(Describe(*identity), token);
  };
}

void SetChecks(const std::shared_ptr<const AccessControl>& access,
               MapStoreServiceOptions& options) {
  options.may_open = MakeSessionCheck(access);
  options.may_restore = MakeRestoreCheck(access);
  options.may_look = MakeLookCheck(access);
  options.may_stay = MakeStayCheck(access);
  options.may_list = MakeListFilter(access);
  options.name_caller = MakeCallerNamer(access);
}

RevokedStreamsEnder::RevokedStreamsEnder(MapStoreService* service,
                                         const std::shared_ptr<const AccessControl>& access) {
  if (access == nullptr) return;
  access->OnRevoked(link_.Guard([service] { service->EndWhoMayNotStay(); }));
}

absl::Status GuardedMapStore::Check(const grpc::CallbackServerContext& context, Action action,
                                    absl::string_view name) const {
  if (access_ == nullptr) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::string mission, MissionOf(name));
  return access_->Check({action, mission, std::nullopt}, EvidenceOf(context), absl::Now());
}

// MakeSessionCheck checks the session's first message, which names mission and agent.
grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* GuardedMapStore::Sync(
    grpc::CallbackServerContext* context) {
  return service_.Sync(context);
}

// MakeListFilter leaves out what the caller may not look into.
grpc::ServerUnaryReactor* GuardedMapStore::ListMissions(grpc::CallbackServerContext* context,
                                                        const v1::ListMissionsRequest* request,
                                                        v1::ListMissionsResponse* response) {
  return service_.ListMissions(context, request, response);
}

grpc::ServerUnaryReactor* GuardedMapStore::GetMission(grpc::CallbackServerContext* context,
                                                      const v1::GetMissionRequest* request,
                                                      v1::Mission* response) {
  const absl::Status status = Check(*context, Action::kLook, request->name());
  return status.ok() ? service_.GetMission(context, request, response) : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::CreateMission(grpc::CallbackServerContext* context,
                                                         const v1::CreateMissionRequest* request,
                                                         v1::Mission* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->mission().name());
  return status.ok() ? service_.CreateMission(context, request, response) : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::UpdateMission(grpc::CallbackServerContext* context,
                                                         const v1::UpdateMissionRequest* request,
                                                         v1::Mission* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->mission().name());
  return status.ok() ? service_.UpdateMission(context, request, response) : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::SetRobotSettings(
    grpc::CallbackServerContext* context, const v1::SetRobotSettingsRequest* request,
    v1::RobotSettingsList* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->name());
  return status.ok() ? service_.SetRobotSettings(context, request, response)
                     : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::GetRobotSettings(
    grpc::CallbackServerContext* context, const v1::GetRobotSettingsRequest* request,
    v1::RobotSettingsList* response) {
  const absl::Status status = Check(*context, Action::kLook, request->name());
  return status.ok() ? service_.GetRobotSettings(context, request, response)
                     : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::DeleteMission(grpc::CallbackServerContext* context,
                                                         const v1::DeleteMissionRequest* request,
                                                         v1::DeleteMissionResponse* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->name());
  return status.ok() ? service_.DeleteMission(context, request, response) : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::SleepMission(grpc::CallbackServerContext* context,
                                                        const v1::SleepMissionRequest* request,
                                                        v1::Mission* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->name());
  return status.ok() ? service_.SleepMission(context, request, response) : Refuse(context, status);
}

grpc::ServerWriteReactor<v1::BackupMissionResponse>* GuardedMapStore::BackupMission(
    grpc::CallbackServerContext* context, const v1::BackupMissionRequest* request) {
  const absl::Status status = Check(*context, Action::kAdminister, request->name());
  if (!status.ok()) return new RefusedStream<v1::BackupMissionResponse>(status);
  return service_.BackupMission(context, request);
}

// MakeRestoreCheck checks the first message, which names the mission.
grpc::ServerReadReactor<v1::RestoreMissionRequest>* GuardedMapStore::RestoreMission(
    grpc::CallbackServerContext* context, v1::Mission* response) {
  return service_.RestoreMission(context, response);
}

grpc::ServerUnaryReactor* GuardedMapStore::ListAgents(grpc::CallbackServerContext* context,
                                                      const v1::ListAgentsRequest* request,
                                                      v1::ListAgentsResponse* response) {
  const absl::Status status = Check(*context, Action::kLook, request->parent());
  return status.ok() ? service_.ListAgents(context, request, response) : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::ListLocalMaps(grpc::CallbackServerContext* context,
                                                         const v1::ListLocalMapsRequest* request,
                                                         v1::ListLocalMapsResponse* response) {
  const absl::Status status = Check(*context, Action::kLook, request->parent());
  return status.ok() ? service_.ListLocalMaps(context, request, response) : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::GetLocalMap(grpc::CallbackServerContext* context,
                                                       const v1::GetLocalMapRequest* request,
                                                       v1::LocalMap* response) {
  const absl::Status status = Check(*context, Action::kLook, request->name());
  return status.ok() ? service_.GetLocalMap(context, request, response) : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::ListKeyframes(grpc::CallbackServerContext* context,
                                                         const v1::ListKeyframesRequest* request,
                                                         v1::ListKeyframesResponse* response) {
  const absl::Status status = Check(*context, Action::kLook, request->parent());
  return status.ok() ? service_.ListKeyframes(context, request, response) : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::GetKeyframe(grpc::CallbackServerContext* context,
                                                       const v1::GetKeyframeRequest* request,
                                                       v1::Keyframe* response) {
  const absl::Status status = Check(*context, Action::kLook, request->name());
  return status.ok() ? service_.GetKeyframe(context, request, response) : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::GetStatistics(grpc::CallbackServerContext* context,
                                                         const v1::GetStatisticsRequest* request,
                                                         v1::GetStatisticsResponse* response) {
  const absl::Status status = Check(*context, Action::kLook, request->mission());
  return status.ok() ? service_.GetStatistics(context, request, response) : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::AskForExactPlaces(
    grpc::CallbackServerContext* context, const v1::AskForExactPlacesRequest* request,
    v1::AskForExactPlacesResponse* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->name());
  return status.ok() ? service_.AskForExactPlaces(context, request, response)
                     : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::RetractOverlap(grpc::CallbackServerContext* context,
                                                          const v1::RetractOverlapRequest* request,
                                                          v1::RetractOverlapResponse* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->name());
  return status.ok() ? service_.RetractOverlap(context, request, response)
                     : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::ForgetLocalMaps(
    grpc::CallbackServerContext* context, const v1::ForgetLocalMapsRequest* request,
    v1::ForgetLocalMapsResponse* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->parent());
  return status.ok() ? service_.ForgetLocalMaps(context, request, response)
                     : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::RederiveGlobalLayer(
    grpc::CallbackServerContext* context, const v1::RederiveGlobalLayerRequest* request,
    v1::RederiveGlobalLayerResponse* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->name());
  return status.ok() ? service_.RederiveGlobalLayer(context, request, response)
                     : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::ListOverlaps(grpc::CallbackServerContext* context,
                                                        const v1::ListOverlapsRequest* request,
                                                        v1::ListOverlapsResponse* response) {
  const absl::Status status = Check(*context, Action::kLook, request->parent());
  return status.ok() ? service_.ListOverlaps(context, request, response) : Refuse(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::GetOverlap(grpc::CallbackServerContext* context,
                                                      const v1::GetOverlapRequest* request,
                                                      v1::Overlap* response) {
  const absl::Status status = Check(*context, Action::kLook, request->name());
  return status.ok() ? service_.GetOverlap(context, request, response) : Refuse(context, status);
}

grpc::ServerWriteReactor<v1::WatchMapResponse>* GuardedMapStore::WatchMap(
    grpc::CallbackServerContext* context, const v1::WatchMapRequest* request) {
  const absl::Status status = Check(*context, Action::kLook, request->mission());
  if (!status.ok()) return new RefusedStream<v1::WatchMapResponse>(status);
  return service_.WatchMap(context, request);
}

grpc::ServerWriteReactor<v1::MissionEvent>* GuardedMapStore::WatchEvents(
    grpc::CallbackServerContext* context, const v1::WatchEventsRequest* request) {
  const absl::Status status = Check(*context, Action::kLook, request->mission());
  if (!status.ok()) return new RefusedStream<v1::MissionEvent>(status);
  return service_.WatchEvents(context, request);
}

grpc::ServerWriteReactor<v1::WatchMapResponse>* GuardedMapStore::ReplayMap(
    grpc::CallbackServerContext* context, const v1::ReplayMapRequest* request) {
  const absl::Status status = Check(*context, Action::kLook, request->mission());
  if (!status.ok()) return new RefusedStream<v1::WatchMapResponse>(status);
  return service_.ReplayMap(context, request);
}

grpc::ServerWriteReactor<v1::GetTrajectoryResponse>* GuardedMapStore::GetTrajectory(
    grpc::CallbackServerContext* context, const v1::GetTrajectoryRequest* request) {
  const absl::Status status = Check(*context, Action::kLook, request->name());
  if (!status.ok()) return new RefusedStream<v1::GetTrajectoryResponse>(status);
  return service_.GetTrajectory(context, request);
}

grpc::ServerUnaryReactor* GuardedMapStore::Localize(grpc::CallbackServerContext* context,
                                                    const v1::LocalizeRequest* request,
                                                    v1::LocalizeResponse* response) {
  const absl::Status status = Check(*context, Action::kLook, request->mission());
  return status.ok() ? service_.Localize(context, request, response) : Refuse(context, status);
}

// MakeLookCheck checks each request, which names its mission.
grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>* GuardedMapStore::LocalizeStream(
    grpc::CallbackServerContext* context) {
  return service_.LocalizeStream(context);
}

}  // namespace corbslam::services
