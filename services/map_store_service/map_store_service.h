// Serves the map store by its contract: MapStore of proto/corbslam/v1/map_store_service.proto.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_MAP_STORE_SERVICE_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_MAP_STORE_SERVICE_H_

#include <grpcpp/support/byte_buffer.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "corbslam/v1/map_store_service.pb.h"
#include "map_store/store/map_store.h"
#include "map_store/store/stored_backups.h"
#include "services/convert/asked_resource.h"
#include "services/map_store_service/streams/recent_codes.h"
#include "services/map_store_service/streams/replay_slots.h"
#include "services/map_store_service/streams/stream_limits.h"
#include "services/map_store_service/streams/sync_observer.h"
#include "services/server/guarded_service.h"
#include "services/server/stream_task.h"
#include "services/server/task_pool.h"
#include "services/server/work_slots.h"

namespace corbslam::services {

struct MapStoreServiceOptions {
  // Number of threads that read and apply batches and answer look-ups. They may be more than
  // processors: they wait for the journal, and one sync then serves several.
  int threads = 8;
  // Size of one shared update, about. With smaller ones a robot on a slow link sees something
  // sooner.
  size_t shared_bytes = 128u << 10;
  StreamLimitOptions streams;
  // Not owned; they must outlive the service.
  std::vector<SyncObserver*> observers;
  // Not owned, must outlive the service; null: the store keeps no backups.
  map_store::StoredBackups* backups = nullptr;
  // Null: everybody may do everything.
  std::shared_ptr<const Door> door = nullptr;
};

// Serves all calls; look-ups, orders and what concerns backups are in a file each, every stream in
// its own. `store` is not owned and must outlive it; the server must be shut down before it is
// destroyed. Thread-safe.
class MapStoreService : public GuardedService {
 public:
  explicit MapStoreService(map_store::MapStore* store, const MapStoreServiceOptions& options = {});
  ~MapStoreService() override { link_.Cut(); }
  MapStoreService(const MapStoreService&) = delete;
  MapStoreService& operator=(const MapStoreService&) = delete;

  // How many pictures are looked up at one time, and how many wait: a look-up waits for workers.
  static constexpr int kMaxLocating = 4;
  static constexpr size_t kMaxWaitingToLocate = 64;
  // How many replays are made or told at one time.
  static constexpr size_t kMaxReplays = 4;
  static constexpr size_t kMaxWaitingForBackups = 16;
  // How many backups, restores, sleeps, deletions and the like are worked on at one time.
  static constexpr int kMaxLongWork = 4;
  // How many of them there are with those that wait: in all, of one caller, about one mission.
  static constexpr size_t kMaxLongCalls = 32;
  static constexpr size_t kMaxLongCallsOfCaller = 16;
  static constexpr size_t kMaxLongCallsOfMission = 8;

  // Ends Sync, WatchMap and WatchEvents with UNAVAILABLE, once what they had to say is said; no new
  // stream begins. The server is about to stop.
  void EndStreams() { limits_.Close(); }

  // Returns the number of calls and batches that no thread has begun with.
  size_t waiting_tasks() const { return pool_.waiting(); }
  const StreamLimits& streams() const { return limits_; }
  const ReplaySlots& replays() const { return replay_slots_; }
  // Returns the number of calls that take long and are under way, or wait.
  size_t long_work() const { return long_work_.size(); }

 private:
  // Returns whether the caller's lists have the mission.
  using IsShown = std::function<bool(const std::string& mission)>;

  // Each call of the contract, with what answers it.
  void ServeCalls();

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Sync(
      grpc::CallbackServerContext* context, MayAsk may_open);
  grpc::ServerWriteReactor<v1::WatchMapResponse>* WatchMap(grpc::CallbackServerContext* context,
                                                           const v1::WatchMapRequest* request);
  grpc::ServerWriteReactor<v1::MissionEvent>* WatchEvents(grpc::CallbackServerContext* context,
                                                          const v1::WatchEventsRequest* request);
  grpc::ServerWriteReactor<v1::WatchMapResponse>* ReplayMap(grpc::CallbackServerContext* context,
                                                            const v1::ReplayMapRequest* request);
  absl::Status ListMissions(const IsShown& is_shown, const v1::ListMissionsRequest& request,
                            v1::ListMissionsResponse* response);
  absl::Status GetMission(const v1::GetMissionRequest& request, v1::Mission* response);
  absl::Status CreateMission(const v1::CreateMissionRequest& request, v1::Mission* response);
  absl::Status SetRobotSettings(const v1::SetRobotSettingsRequest& request,
                                v1::RobotSettingsList* response);
  absl::Status GetRobotSettings(const v1::GetRobotSettingsRequest& request,
                                v1::RobotSettingsList* response);
  absl::Status UpdateMission(const v1::UpdateMissionRequest& request, v1::Mission* response);
  absl::Status DeleteMission(const v1::DeleteMissionRequest& request,
                             v1::DeleteMissionResponse* response);
  absl::Status SleepMission(const v1::SleepMissionRequest& request, v1::Mission* response);
  grpc::ServerWriteReactor<v1::BackupMissionResponse>* BackupMission(
      grpc::CallbackServerContext* context, const v1::BackupMissionRequest* request);
  grpc::ServerReadReactor<v1::RestoreMissionRequest>* RestoreMission(
      grpc::CallbackServerContext* context, MayAsk may_restore, v1::Mission* response);
  absl::Status StoreBackup(const v1::StoreBackupRequest& request, v1::StoredBackup* response);
  absl::Status ListStoredBackups(const IsShown& is_shown,
                                 const v1::ListStoredBackupsRequest& request,
                                 v1::ListStoredBackupsResponse* response);
  absl::Status RestoreStoredBackup(const v1::RestoreStoredBackupRequest& request,
                                   v1::Mission* response);
  absl::Status VerifyStoredBackup(const v1::VerifyStoredBackupRequest& request,
                                  v1::StoredBackup* response);
  absl::Status DeleteStoredBackup(const v1::DeleteStoredBackupRequest& request,
                                  v1::StoredBackup* response);
  absl::Status ArchiveMission(const v1::ArchiveMissionRequest& request, v1::StoredBackup* response);
  absl::Status ListAgents(const v1::ListAgentsRequest& request, v1::ListAgentsResponse* response);
  absl::Status ListLocalMaps(const v1::ListLocalMapsRequest& request,
                             v1::ListLocalMapsResponse* response);
  absl::Status GetLocalMap(const v1::GetLocalMapRequest& request, v1::LocalMap* response);
  absl::Status ListKeyframes(const v1::ListKeyframesRequest& request,
                             v1::ListKeyframesResponse* response);
  absl::Status GetKeyframe(const v1::GetKeyframeRequest& request, v1::Keyframe* response);
  absl::Status GetStatistics(const v1::GetStatisticsRequest& request,
                             v1::GetStatisticsResponse* response);
  grpc::ServerWriteReactor<v1::GetTrajectoryResponse>* GetTrajectory(
      grpc::CallbackServerContext* context, const v1::GetTrajectoryRequest* request);
  absl::Status ListOverlaps(const v1::ListOverlapsRequest& request,
                            v1::ListOverlapsResponse* response);
  absl::Status GetOverlap(const v1::GetOverlapRequest& request, v1::Overlap* response);
  absl::Status AskForExactPlaces(const v1::AskForExactPlacesRequest& request,
                                 v1::AskForExactPlacesResponse* response);
  absl::Status RetractOverlap(const v1::RetractOverlapRequest& request,
                              v1::RetractOverlapResponse* response);
  absl::Status ForgetLocalMaps(const v1::ForgetLocalMapsRequest& request,
                               v1::ForgetLocalMapsResponse* response);
  absl::Status RederiveGlobalLayer(const v1::RederiveGlobalLayerRequest& request,
                                   v1::RederiveGlobalLayerResponse* response);

  grpc::ServerUnaryReactor* Localize(grpc::CallbackServerContext* context,
                                     const v1::LocalizeRequest* request,
                                     v1::LocalizeResponse* response);
  grpc::ServerBidiReactor<v1::LocalizeRequest, v1::LocalizeResponse>* LocalizeStream(
      grpc::CallbackServerContext* context, MayAsk may_look);

  StayCheck MayStay(const grpc::CallbackServerContext& context) const {
    if (door() == nullptr) return nullptr;
    return [caller = door()->Meet(context)] { return caller->MayStay(); };
  }
  // Counts work that takes long, for its caller and the mission in `name`.
  absl::StatusOr<std::shared_ptr<const void>> EnterLongWork(
      const grpc::CallbackServerContext& context, const std::string& name);
  // The same as Serve, for what takes long, about the resource that the call names.
  template <typename Request, typename Response>
  void ServeLong(const char* name, TaskPool& pool,
                 absl::Status (MapStoreService::*call)(const Request&, Response*)) {
    const google::protobuf::MethodDescriptor* method = service().FindMethodByName(name);
    Serve<Request, Response>(
        name, [this, method, &pool, call](grpc::CallbackServerContext* context,
                                          const Request* request, Response* response) {
          return AnswerLong(
              pool, context, ResourceOf(*method, *request),
              [this, call, request, response] { return (this->*call)(*request, response); });
        });
  }
  // The same as Serve, for a list that has what the caller may look into.
  template <typename Request, typename Response>
  void ServeList(const char* name, TaskPool& pool,
                 absl::Status (MapStoreService::*call)(const IsShown&, const Request&, Response*)) {
    Serve<Request, Response>(name, [this, &pool, call](grpc::CallbackServerContext* context,
                                                       const Request* request, Response* response) {
      return AnswerOn(pool, context, [this, is_shown = Shows(*context), call, request, response] {
        return (this->*call)(is_shown, *request, response);
      });
    });
  }
  // As AnswerOn, for what takes long.
  grpc::ServerUnaryReactor* AnswerLong(TaskPool& pool, grpc::CallbackServerContext* context,
                                       const std::string& name,
                                       const std::function<absl::Status()>& answer);
  absl::Status AnswerLocalize(const v1::LocalizeRequest& request,
                              const std::function<bool()>& goes_on, v1::LocalizeResponse* response);
  // Returns which missions the caller's lists have.
  IsShown Shows(const grpc::CallbackServerContext& context) const {
    if (door() == nullptr) return [](const std::string&) { return true; };
    return
        [caller = door()->Meet(context)](const auto& mission) { return caller->MayLook(mission); };
  }
  // Returns who the caller is, for logs; empty if nobody knows.
  std::string NameOf(const grpc::CallbackServerContext& context) const {
    return door() != nullptr ? door()->Meet(context)->name() : "";
  }
  static MapStoreServiceOptions Observed(MapStoreServiceOptions options, SyncObserver* observer) {
    options.observers.push_back(observer);
    return options;
  }

  map_store::MapStore& store_;
  RecentCodes recent_codes_;
  const MapStoreServiceOptions options_;
  StreamLimits limits_;
  ReplaySlots replay_slots_{kMaxReplays};
  TaskPool pool_;
  // Its one thread makes replays, one after the other: they would keep look-ups waiting for long.
  TaskPool replay_pool_{0, kMaxReplays};
  // Its threads replay or write whole missions.
  const std::unique_ptr<TaskPool> long_ = TaskPool::ForLongWork(kMaxLongWork, kMaxLongCalls);
  TaskPool& long_pool_ = *long_;
  WorkSlots long_work_{{.what = "backups, restores, sleeps and deletions",
                        .all = kMaxLongCalls,
                        .of_caller = kMaxLongCallsOfCaller,
                        .of_resource = kMaxLongCallsOfMission}};
  // Its one thread makes, reads and lists backups, which takes as long as a disk does.
  TaskPool backup_pool_{0, kMaxWaitingForBackups};
  // Its threads wait for workers most of the time.
  const std::unique_ptr<TaskPool> locating_ =
      TaskPool::ForLookUps(kMaxLocating, kMaxWaitingToLocate);
  TaskPool& locating_pool_ = *locating_;
  StreamLink link_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_MAP_STORE_SERVICE_H_
