#include "services/map_store_service/map_store_service.h"

#include <optional>
#include <string>
#include <utility>

#include "map_store/view/asleep_error.h"

namespace corbslam::services {

MapStoreService::MapStoreService(map_store::MapStore* store, const MapStoreServiceOptions& options)
    : GuardedService(*v1::SyncRequest::descriptor()->file()->service(0), options.door),
      store_(*store),
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
  ServeCalls();
  if (door() != nullptr) door()->OnRevoked(link_.Guard([this] { limits_.EndWhoMayNotStay(); }));
}

void MapStoreService::ServeCalls() {
  Serve("Sync", &MapStoreService::Sync);
  Serve("WatchMap", &MapStoreService::WatchMap);
  Serve("WatchEvents", &MapStoreService::WatchEvents);
  Serve("ReplayMap", &MapStoreService::ReplayMap);
  ServeList("ListMissions", pool_, &MapStoreService::ListMissions);
  Serve("GetMission", pool_, &MapStoreService::GetMission);
  Serve("CreateMission", pool_, &MapStoreService::CreateMission);
  Serve("SetRobotSettings", pool_, &MapStoreService::SetRobotSettings);
  Serve("GetRobotSettings", pool_, &MapStoreService::GetRobotSettings);
  Serve("UpdateMission", pool_, &MapStoreService::UpdateMission);
  ServeLong("DeleteMission", long_pool_, &MapStoreService::DeleteMission);
  ServeLong("SleepMission", long_pool_, &MapStoreService::SleepMission);
  Serve("BackupMission", &MapStoreService::BackupMission);
  Serve("RestoreMission", &MapStoreService::RestoreMission);
  ServeLong("StoreBackup", backup_pool_, &MapStoreService::StoreBackup);
  ServeList("ListStoredBackups", backup_pool_, &MapStoreService::ListStoredBackups);
  ServeLong("RestoreStoredBackup", backup_pool_, &MapStoreService::RestoreStoredBackup);
  ServeLong("VerifyStoredBackup", backup_pool_, &MapStoreService::VerifyStoredBackup);
  ServeLong("DeleteStoredBackup", backup_pool_, &MapStoreService::DeleteStoredBackup);
  ServeLong("ArchiveMission", backup_pool_, &MapStoreService::ArchiveMission);
  Serve("ListAgents", pool_, &MapStoreService::ListAgents);
  Serve("ListLocalMaps", pool_, &MapStoreService::ListLocalMaps);
  Serve("GetLocalMap", pool_, &MapStoreService::GetLocalMap);
  Serve("ListKeyframes", pool_, &MapStoreService::ListKeyframes);
  Serve("GetKeyframe", pool_, &MapStoreService::GetKeyframe);
  Serve("GetStatistics", pool_, &MapStoreService::GetStatistics);
  Serve("GetTrajectory", &MapStoreService::GetTrajectory);
  Serve("ListOverlaps", pool_, &MapStoreService::ListOverlaps);
  Serve("GetOverlap", pool_, &MapStoreService::GetOverlap);
  Serve("AskForExactPlaces", pool_, &MapStoreService::AskForExactPlaces);
  ServeLong("RetractOverlap", long_pool_, &MapStoreService::RetractOverlap);
  ServeLong("ForgetLocalMaps", long_pool_, &MapStoreService::ForgetLocalMaps);
  ServeLong("RederiveGlobalLayer", long_pool_, &MapStoreService::RederiveGlobalLayer);
  Serve("Localize", &MapStoreService::Localize);
  Serve("LocalizeStream", &MapStoreService::LocalizeStream);
}

}  // namespace corbslam::services
