#include <glog/logging.h>

#include <optional>

#include "absl/time/time.h"
#include "services/convert/resource_names.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/paging.h"
#include "services/map_store_service/stored_backup_message.h"
#include "services/observe/logging/log_fields.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::PageRequest;

absl::Status MapStoreService::StoreBackup(const v1::StoreBackupRequest& request,
                                          v1::StoredBackup* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.name()));
  RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
  ASSIGN_OR_RETURN(const map_store::StoredBackup made, options_.backups->Store(mission));
  LOG(INFO) << LogFields{.mission = mission} << "backup " << made.number << " stored";
  ToProto(made, response);
  return absl::OkStatus();
}

absl::Status MapStoreService::ListStoredBackups(const IsShown& is_shown,
                                                const v1::ListStoredBackupsRequest& request,
                                                v1::ListStoredBackupsResponse* response) {
  std::string mission;
  if (request.parent() != kAllMissions) {
    ASSIGN_OR_RETURN(mission, ParseMissionName(request.parent()));
  }
  RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
  ASSIGN_OR_RETURN(PageRequest page, ReadPage(request));
  // As ListMissions: the page is full with what is shown.
  do {
    ASSIGN_OR_RETURN(const auto found, options_.backups->List(mission, page));
    for (const map_store::StoredBackup& backup : found.items) {
      if (!is_shown(backup.mission)) continue;
      ToProto(backup, response->add_backups());
      --page.page_size;
    }
    page.page_token = found.next_page_token;
  } while (page.page_size > 0 && !page.page_token.empty());
  response->set_next_page_token(page.page_token);
  return absl::OkStatus();
}

absl::Status MapStoreService::RestoreStoredBackup(const v1::RestoreStoredBackupRequest& request,
                                                  v1::Mission* response) {
  ASSIGN_OR_RETURN(const BackupPath path, ParseBackupName(request.backup()));
  std::string name = path.mission;
  if (!request.name().empty()) {
    ASSIGN_OR_RETURN(name, ParseMissionName(request.name()));
  }
  RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
  RETURN_IF_ERROR(options_.backups->Restore(path.mission, path.number, name));
  LOG(INFO) << LogFields{.mission = name} << "mission restored from " << request.backup();
  ASSIGN_OR_RETURN(const map_store::MissionInfo info, store_.GetMission(name));
  ToProto(info, response);
  return absl::OkStatus();
}

absl::Status MapStoreService::VerifyStoredBackup(const v1::VerifyStoredBackupRequest& request,
                                                 v1::StoredBackup* response) {
  ASSIGN_OR_RETURN(const BackupPath path, ParseBackupName(request.backup()));
  RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
  ASSIGN_OR_RETURN(const map_store::StoredBackup verified,
                   options_.backups->Verify(path.mission, path.number));
  ToProto(verified, response);
  return absl::OkStatus();
}

absl::Status MapStoreService::DeleteStoredBackup(const v1::DeleteStoredBackupRequest& request,
                                                 v1::StoredBackup* response) {
  ASSIGN_OR_RETURN(const BackupPath path, ParseBackupName(request.backup()));
  RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
  std::optional<absl::Time> created;
  if (request.created_ns() != 0) {
    created = absl::FromUnixNanos(request.created_ns());
  }
  ASSIGN_OR_RETURN(const map_store::StoredBackup removed,
                   options_.backups->Remove(path.mission, path.number, created));
  LOG(INFO) << LogFields{.mission = path.mission} << "backup " << path.number << " deleted";
  ToProto(removed, response);
  return absl::OkStatus();
}

absl::Status MapStoreService::ArchiveMission(const v1::ArchiveMissionRequest& request,
                                             v1::StoredBackup* response) {
  ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request.name()));
  RETURN_IF_ERROR(CheckKeepsBackups(options_.backups));
  ASSIGN_OR_RETURN(const map_store::StoredBackup made, options_.backups->Archive(mission));
  LOG(INFO) << LogFields{.mission = mission} << "mission archived as backup " << made.number;
  ToProto(made, response);
  return absl::OkStatus();
}

}  // namespace corbslam::services
