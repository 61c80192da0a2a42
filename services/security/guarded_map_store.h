// Puts an access control that knows which mission each request is about before a map store's
// service.
#ifndef CORBSLAM_SERVICES_SECURITY_GUARDED_MAP_STORE_H_
#define CORBSLAM_SERVICES_SECURITY_GUARDED_MAP_STORE_H_

#include <memory>

#include "absl/strings/string_view.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/map_store_service/map_store_service.h"
#include "services/security/access_control.h"
#include "services/server/stream_task.h"

namespace corbslam::services {

// Makes a check for MapStoreServiceOptions: an agent opens sessions as itself only. Null access:
// everybody may open any session.
SessionCheck MakeSessionCheck(std::shared_ptr<const AccessControl> access);
// Makes a check likewise: operators restore missions of their own.
RestoreCheck MakeRestoreCheck(std::shared_ptr<const AccessControl> access);
// Makes a check likewise, for streams that look into missions.
LookCheck MakeLookCheck(std::shared_ptr<const AccessControl> access);

// Makes a check likewise: streams stay open until their caller is revoked.
StayCheckMaker MakeStayCheck(std::shared_ptr<const AccessControl> access);
// Makes a check likewise: a list has the missions that its caller may look into.
ListFilterMaker MakeListFilter(std::shared_ptr<const AccessControl> access);
// Names callers by their grants, and the token that they showed.
CallerNamer MakeCallerNamer(std::shared_ptr<const AccessControl> access);
// Sets all these.
void SetChecks(const std::shared_ptr<const AccessControl>& access, MapStoreServiceOptions& options);

// Ends the streams of callers that are revoked, as long as it lives.
class RevokedStreamsEnder {
 public:
  // `service` is not owned and must outlive it; its options have MakeStayCheck's. Null access:
  // nobody is ever revoked.
  RevokedStreamsEnder(MapStoreService* service, const std::shared_ptr<const AccessControl>& access);
  ~RevokedStreamsEnder() { link_.Cut(); }
  RevokedStreamsEnder(const RevokedStreamsEnder&) = delete;
  RevokedStreamsEnder& operator=(const RevokedStreamsEnder&) = delete;

 private:
  StreamLink link_;
};

// Checks each call and hands it on to `service`, which is not owned and must outlive it.
// Thread-safe. A method that it does not hand on is UNIMPLEMENTED, so that a new one is closed
// until somebody says who may call it. Null access: everybody may do everything.
class GuardedMapStore : public MapStoreMethods {
 public:
  GuardedMapStore(MapStoreMethods* service, std::shared_ptr<const AccessControl> access)
      : service_(*service), access_(std::move(access)) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Sync(
      grpc::CallbackServerContext* context) override;
  grpc::ServerWriteReactor<v1::WatchMapResponse>* WatchMap(
      grpc::CallbackServerContext* context, const v1::WatchMapRequest* request) override;
  grpc::ServerWriteReactor<v1::MissionEvent>* WatchEvents(
      grpc::CallbackServerContext* context, const v1::WatchEventsRequest* request) override;
  grpc::ServerWriteReactor<v1::WatchMapResponse>* ReplayMap(
      grpc::CallbackServerContext* context, const v1::ReplayMapRequest* request) override;
  grpc::ServerUnaryReactor* ListMissions(grpc::CallbackServerContext* context,
                                         const v1::ListMissionsRequest* request,
                                         v1::ListMissionsResponse* response) override;
  grpc::ServerUnaryReactor* GetMission(grpc::CallbackServerContext* context,
                                       const v1::GetMissionRequest* request,
                                       v1::Mission* response) override;
  grpc::ServerUnaryReactor* CreateMission(grpc::CallbackServerContext* context,
                                          const v1::CreateMissionRequest* request,
                                          v1::Mission* response) override;
  grpc::ServerUnaryReactor* UpdateMission(grpc::CallbackServerContext* context,
                                          const v1::UpdateMissionRequest* request,
                                          v1::Mission* response) override;
  grpc::ServerUnaryReactor* SetRobotSettings(grpc::CallbackServerContext* context,
                                             const v1::SetRobotSettingsRequest* request,
                                             v1::RobotSettingsList* response) override;
  grpc::ServerUnaryReactor* GetRobotSettings(grpc::CallbackServerContext* context,
                                             const v1::GetRobotSettingsRequest* request,
                                             v1::RobotSettingsList* response) override;
  grpc::ServerUnaryReactor* DeleteMission(grpc::CallbackServerContext* context,
                                          const v1::DeleteMissionRequest* request,
                                          v1::DeleteMissionResponse* response) override;
  grpc::ServerUnaryReactor* SleepMission(grpc::CallbackServerContext* context,
                                         const v1::SleepMissionRequest* request,
                                         v1::Mission* response) override;
  grpc::ServerWriteReactor<v1::BackupMissionResponse>* BackupMission(
      grpc::CallbackServerContext* context, const v1::BackupMissionRequest* request) override;
  grpc::ServerReadReactor<v1::RestoreMissionRequest>* RestoreMission(
      grpc::CallbackServerContext* context, v1::Mission* response) override;
  grpc::ServerUnaryReactor* StoreBackup(grpc::CallbackServerContext* context,
                                        const v1::StoreBackupRequest* request,
                                        v1::StoredBackup* response) override;
  grpc::ServerUnaryReactor* ListStoredBackups(grpc::CallbackServerContext* context,
                                              const v1::ListStoredBackupsRequest* request,
                                              v1::ListStoredBackupsResponse* response) override;
  grpc::ServerUnaryReactor* RestoreStoredBackup(grpc::CallbackServerContext* context,
                                                const v1::RestoreStoredBackupRequest* request,
                                                v1::Mission* response) override;
  grpc::ServerUnaryReactor* VerifyStoredBackup(grpc::CallbackServerContext* context,
                                               const v1::VerifyStoredBackupRequest* request,
                                               v1::StoredBackup* response) override;
  grpc::ServerUnaryReactor* DeleteStoredBackup(grpc::CallbackServerContext* context,
                                               const v1::DeleteStoredBackupRequest* request,
                                               v1::StoredBackup* response) override;
  grpc::ServerUnaryReactor* ArchiveMission(grpc::CallbackServerContext* context,
                                           const v1::ArchiveMissionRequest* request,
                                           v1::StoredBackup* response) override;
  grpc::ServerUnaryReactor* ListAgents(grpc::CallbackServerContext* context,
                                       const v1::ListAgentsRequest* request,
                                       v1::ListAgentsResponse* response) override;
  grpc::ServerUnaryReactor* ListLocalMaps(grpc::CallbackServerContext* context,
                                          const v1::ListLocalMapsRequest* request,
                                          v1::ListLocalMapsResponse* response) override;
  grpc::ServerUnaryReactor* GetLocalMap(grpc::CallbackServerContext* context,
                                        const v1::GetLocalMapRequest* request,
                                        v1::LocalMap* response) override;
  grpc::ServerUnaryReactor* ListKeyframes(grpc::CallbackServerContext* context,
                                          const v1::ListKeyframesRequest* request,
                                          v1::ListKeyframesResponse* response) override;
  grpc::ServerUnaryReactor* GetKeyframe(grpc::CallbackServerContext* context,
                                        const v1::GetKeyframeRequest* request,
                                        v1::Keyframe* response) override;
  grpc::ServerUnaryReactor* GetStatistics(grpc::CallbackServerContext* context,
                                          const v1::GetStatisticsRequest* request,
                                          v1::GetStatisticsResponse* response) override;
  grpc::ServerWriteReactor<v1::GetTrajectoryResponse>* GetTrajectory(
      grpc::CallbackServerContext* context, const v1::GetTrajectoryRequest* request) override;
  grpc::ServerUnaryReactor* ListOverlaps(grpc::CallbackServerContext* context,
                                         const v1::ListOverlapsRequest* request,
                                         v1::ListOverlapsResponse* response) override;
  grpc::ServerUnaryReactor* AskForExactPlaces(grpc::CallbackServerContext* context,
                                              const v1::AskForExactPlacesRequest* request,
                                              v1::AskForExactPlacesResponse* response) override;
  grpc::ServerUnaryReactor* GetOverlap(grpc::CallbackServerContext* context,
                                       const v1::GetOverlapRequest* request,
                                       v1::Overlap* response) override;
  grpc::ServerUnaryReactor* RetractOverlap(grpc::CallbackServerContext* context,
                                           const v1::RetractOverlapRequest* request,
                                           v1::RetractOverlapResponse* response) override;
  grpc::ServerUnaryReactor* ForgetLocalMaps(grpc::CallbackServerContext* context,
                                            const v1::ForgetLocalMapsRequest* request,
                                            v1::ForgetLocalMapsResponse* response) override;
  grpc::ServerUnaryReactor* RederiveGlobalLayer(grpc::CallbackServerContext* context,
                                                const v1::RederiveGlobalLayerRequest* request,
                                                v1::RederiveGlobalLayerResponse* response) override;

  grpc::ServerUnaryReactor* Localize(grpc::CallbackServerContext* context,
                                     const v1::LocalizeRequest* request,
                                     v1::LocalizeResponse* response) override;
  grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>* LocalizeStream(
      grpc::CallbackServerContext* context) override;

 private:
  // Checks a resource's name, which begins with its mission's.
  absl::Status Check(const grpc::CallbackServerContext& context, Action action,
                     absl::string_view name) const;

  MapStoreMethods& service_;
  const std::shared_ptr<const AccessControl> access_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_GUARDED_MAP_STORE_H_
