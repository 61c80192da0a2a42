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

#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "map_store/store/map_store.h"
#include "map_store/store/stored_backups.h"
#include "map_store/view/asleep_words.h"
#include "services/map_store_service/streams/recent_codes.h"
#include "services/map_store_service/streams/replay_slots.h"
#include "services/map_store_service/streams/stream_limits.h"
#include "services/map_store_service/streams/sync_observer.h"
#include "services/server/task_pool.h"
#include "services/server/work_slots.h"

namespace corbslam::services {

// Has all methods, with Sync's messages as bytes: a message that can't be read would otherwise look
// like the end of the stream.
using MapStoreBackupMethods =
    v1::MapStore::WithCallbackMethod_StoreBackup<v1::MapStore::WithCallbackMethod_ListStoredBackups<
        v1::MapStore::WithCallbackMethod_RestoreStoredBackup<
            v1::MapStore::WithCallbackMethod_VerifyStoredBackup<
                v1::MapStore::WithCallbackMethod_DeleteStoredBackup<
                    v1::MapStore::WithCallbackMethod_ArchiveMission<
                        v1::MapStore::WithCallbackMethod_ForgetLocalMaps<
                            v1::MapStore::Service>>>>>>>;
using MapStoreSettingsMethods = v1::MapStore::WithCallbackMethod_SetRobotSettings<
    v1::MapStore::WithCallbackMethod_GetRobotSettings<
        v1::MapStore::WithCallbackMethod_GetOverlap<MapStoreBackupMethods>>>;
using MapStoreMethods = v1::MapStore::WithRawCallbackMethod_Sync<v1::MapStore::WithCallbackMethod_WatchMap<
    v1::MapStore::WithCallbackMethod_WatchEvents<v1::MapStore::WithCallbackMethod_ReplayMap<
        v1::MapStore::WithCallbackMethod_ListMissions<v1::MapStore::WithCallbackMethod_GetMission<
            v1::MapStore::WithCallbackMethod_DeleteMission<v1::MapStore::WithCallbackMethod_BackupMission<
                v1::MapStore::WithCallbackMethod_RestoreMission<v1::MapStore::WithCallbackMethod_ListAgents<
                    v1::MapStore::WithCallbackMethod_ListLocalMaps<v1::MapStore::WithCallbackMethod_GetLocalMap<
                        v1::MapStore::WithCallbackMethod_ListKeyframes<v1::MapStore::WithCallbackMethod_GetKeyframe<
                            v1::MapStore::WithCallbackMethod_GetStatistics<v1::MapStore::WithCallbackMethod_GetTrajectory<
                                v1::MapStore::WithCallbackMethod_ListOverlaps<v1::MapStore::WithCallbackMethod_RetractOverlap<
                                    v1::MapStore::WithCallbackMethod_RederiveGlobalLayer<
                                        v1::MapStore::WithCallbackMethod_AskForExactPlaces<
                                            v1::MapStore::WithCallbackMethod_Localize<
                                                v1::MapStore::WithCallbackMethod_LocalizeStream<
                                                    v1::MapStore::WithCallbackMethod_CreateMission<
                                                        v1::MapStore::WithCallbackMethod_UpdateMission<
                                                            v1::MapStore::WithCallbackMethod_SleepMission<
                                                                MapStoreSettingsMethods>>>>>>>>>>>>>>>>>>>>>>>>>;

// Returns OK if the caller may open a session as this agent of this mission.
using SessionCheck = std::function<absl::Status(
    const grpc::CallbackServerContext&, const std::string& mission, const std::string& agent)>;

// Returns OK if the caller may restore this mission, which its request names only once it has
// begun.
using RestoreCheck =
    std::function<absl::Status(const grpc::CallbackServerContext&, const std::string& mission)>;

// Returns OK if the caller may look into what has this name, which begins with its mission's.
using LookCheck =
    std::function<absl::Status(const grpc::CallbackServerContext&, const std::string& name)>;

// Returns a check of whether the caller's streams may stay open (StreamLimits::EndWhoMayNotStay).
using StayCheckMaker = std::function<StayCheck(const grpc::CallbackServerContext&)>;

// Returns who the caller is, for logs; empty if nobody knows.
using CallerNamer = std::function<std::string(const grpc::CallbackServerContext&)>;

// Returns a check of which missions the caller's list has.
using ListFilter = std::function<bool(const std::string& mission)>;
using ListFilterMaker = std::function<ListFilter(const grpc::CallbackServerContext&)>;

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
  // Null: everybody may.
  SessionCheck may_open;
  RestoreCheck may_restore;
  LookCheck may_look;  // Of LocalizeStream, each of whose requests names a mission.
  StayCheckMaker may_stay;
  ListFilterMaker may_list;
  CallerNamer name_caller;
};

// Serves all calls; each RPC is in the file of its name. `store` is not owned and must outlive it;
// the server must be shut down before it is destroyed. Thread-safe.
class MapStoreService : public MapStoreMethods {
 public:
  explicit MapStoreService(map_store::MapStore* store, const MapStoreServiceOptions& options = {})
      : store_(*store),
        options_(Observed(options, &recent_codes_)),
        limits_(options.streams),
        pool_(options.threads, options.streams.max_waiting_calls) {
    // Who needs a mission that is asleep gives its thread to others meanwhile.
    for (TaskPool* pool : {&pool_, &replay_pool_, &long_pool_, locating_.get()}) {
      pool->SetDeferrer([store](const absl::Status& error, TaskPool::Again again) {
        const std::optional<std::string> mission = map_store::AsleepMission(error);
        return mission.has_value() ? store->WhenAwake(*mission, std::move(again)) : error;
      });
    }
  }

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

  // Ends those of these streams whose callers may not stay any more, with the reason.
  void EndWhoMayNotStay() { limits_.EndWhoMayNotStay(); }

  // Returns the number of calls and batches that no thread has begun with.
  size_t waiting_tasks() const { return pool_.waiting(); }
  const StreamLimits& streams() const { return limits_; }
  const ReplaySlots& replays() const { return replay_slots_; }
  // Returns the number of calls that take long and are under way, or wait.
  size_t long_work() const { return long_work_.size(); }

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
  grpc::ServerUnaryReactor* SetRobotSettings(grpc::CallbackServerContext* context,
                                             const v1::SetRobotSettingsRequest* request,
                                             v1::RobotSettingsList* response) override;
  grpc::ServerUnaryReactor* GetRobotSettings(grpc::CallbackServerContext* context,
                                             const v1::GetRobotSettingsRequest* request,
                                             v1::RobotSettingsList* response) override;
  grpc::ServerUnaryReactor* UpdateMission(grpc::CallbackServerContext* context,
                                          const v1::UpdateMissionRequest* request,
                                          v1::Mission* response) override;
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
  grpc::ServerUnaryReactor* GetOverlap(grpc::CallbackServerContext* context,
                                       const v1::GetOverlapRequest* request,
                                       v1::Overlap* response) override;
  grpc::ServerUnaryReactor* AskForExactPlaces(grpc::CallbackServerContext* context,
                                              const v1::AskForExactPlacesRequest* request,
                                              v1::AskForExactPlacesResponse* response) override;
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
  StayCheck MayStay(const grpc::CallbackServerContext& context) const {
    return options_.may_stay != nullptr ? options_.may_stay(context) : nullptr;
  }
  // Counts work that takes long, for its caller and the mission in `name`.
  absl::StatusOr<std::shared_ptr<const void>> EnterLongWork(
      const grpc::CallbackServerContext& context, const std::string& name);
  // As AnswerOn, for what takes long.
  grpc::ServerUnaryReactor* AnswerLong(TaskPool& pool, grpc::CallbackServerContext* context,
                                       const std::string& name,
                                       const std::function<absl::Status()>& answer);
  absl::Status AnswerLocalize(const v1::LocalizeRequest& request,
                              const std::function<bool()>& goes_on, v1::LocalizeResponse* response);
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
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_MAP_STORE_SERVICE_H_
