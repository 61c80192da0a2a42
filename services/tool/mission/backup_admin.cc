#include "services/tool/mission/backup_admin.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "services/client/store/call_status.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

std::string FormatTime(int64_t created_ns) {
  return absl::FormatTime(absl::RFC3339_sec, absl::FromUnixNanos(created_ns), absl::UTCTimeZone());
}

}  // namespace

BackupAdmin::BackupAdmin(const std::shared_ptr<grpc::Channel>& channel)
    : stub_(v1::MapStore::NewStub(channel)) {}

absl::StatusOr<v1::StoredBackup> BackupAdmin::Store(const std::string& mission) {
  grpc::ClientContext context;
  v1::StoreBackupRequest request;
  request.set_name(MissionName(mission));
  v1::StoredBackup made;
  RETURN_IF_ERROR(ToStatus(stub_->StoreBackup(&context, request, &made), "StoreBackup"));
  return made;
}

absl::StatusOr<std::vector<v1::StoredBackup>> BackupAdmin::List(const std::string& mission) {
  std::vector<v1::StoredBackup> backups;
  v1::ListStoredBackupsRequest request;
  request.set_parent(mission.empty() ? std::string(kAllMissions) : MissionName(mission));
  do {
    grpc::ClientContext context;
    SetDeadline(context);
    v1::ListStoredBackupsResponse response;
    RETURN_IF_ERROR(
        ToStatus(stub_->ListStoredBackups(&context, request, &response), "ListStoredBackups"));
    backups.insert(backups.end(), response.backups().begin(), response.backups().end());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return backups;
}

absl::StatusOr<v1::StoredBackup> BackupAdmin::Verify(const std::string& backup) {
  grpc::ClientContext context;
  v1::VerifyStoredBackupRequest request;
  request.set_backup(backup);
  v1::StoredBackup verified;
  RETURN_IF_ERROR(
      ToStatus(stub_->VerifyStoredBackup(&context, request, &verified), "VerifyStoredBackup"));
  return verified;
}

absl::StatusOr<v1::StoredBackup> BackupAdmin::Find(const std::string& backup) {
  ASSIGN_OR_RETURN(const BackupPath path, ParseBackupName(backup));
  ASSIGN_OR_RETURN(const std::vector<v1::StoredBackup> backups, List(path.mission));
  const auto found = std::ranges::find(backups, backup, &v1::StoredBackup::name);
  if (found != backups.end()) return *found;
  return absl::NotFoundError(absl::StrCat("the store lists no backup ", backup));
}

absl::StatusOr<v1::StoredBackup> BackupAdmin::Delete(const std::string& backup,
                                                     int64_t created_ns) {
  grpc::ClientContext context;
  v1::DeleteStoredBackupRequest request;
  request.set_backup(backup);
  request.set_created_ns(created_ns);
  v1::StoredBackup deleted;
  RETURN_IF_ERROR(
      ToStatus(stub_->DeleteStoredBackup(&context, request, &deleted), "DeleteStoredBackup"));
  return deleted;
}

absl::StatusOr<v1::StoredBackup> BackupAdmin::Archive(const std::string& mission) {
  grpc::ClientContext context;
  v1::ArchiveMissionRequest request;
  request.set_name(MissionName(mission));
  v1::StoredBackup made;
  RETURN_IF_ERROR(ToStatus(stub_->ArchiveMission(&context, request, &made), "ArchiveMission"));
  return made;
}

absl::StatusOr<v1::Mission> BackupAdmin::Restore(const std::string& backup,
                                                 const std::string& mission) {
  grpc::ClientContext context;
  v1::RestoreStoredBackupRequest request;
  request.set_backup(backup);
  if (!mission.empty()) request.set_name(MissionName(mission));
  v1::Mission restored;
  RETURN_IF_ERROR(
      ToStatus(stub_->RestoreStoredBackup(&context, request, &restored), "RestoreStoredBackup"));
  return restored;
}

absl::StatusOr<v1::StoredBackup> BackupAdmin::FindAt(const std::string& mission, absl::Time at) {
  ASSIGN_OR_RETURN(const std::vector<v1::StoredBackup> backups, List(mission));
  const v1::StoredBackup* best = nullptr;
  for (const v1::StoredBackup& backup : backups) {
    if (absl::FromUnixNanos(backup.created_ns()) > at) continue;
    // One that can't be restored is no choice, as long as there is another.
    const bool is_sounder = best == nullptr || (!best->damage().empty() && backup.damage().empty());
    const bool is_as_sound = best != nullptr && best->damage().empty() == backup.damage().empty();
    if (is_sounder || (is_as_sound && backup.created_ns() >= best->created_ns())) best = &backup;
  }
  if (best != nullptr) return *best;
  if (backups.empty()) {
    return absl::NotFoundError(absl::StrCat("the store has no backups of mission ", mission));
  }
  const auto oldest = std::ranges::min_element(backups, {}, &v1::StoredBackup::created_ns);
  return absl::NotFoundError(
      absl::StrCat("the oldest backup of mission ", mission, " is ", oldest->name(), " of ",
                   FormatTime(oldest->created_ns()), ", newer than ",
                   absl::FormatTime(absl::RFC3339_sec, at, absl::UTCTimeZone())));
}

absl::StatusOr<absl::Time> ParseBackupTime(const std::string& text) {
  absl::Time time;
  std::string error;
  if (absl::ParseTime(absl::RFC3339_full, text, &time, &error)) return time;
  return absl::InvalidArgumentError(
      absl::StrCat("--at is \"", text, "\", must be a time with its zone, as ",
                   "2026-11-28T14:30:00Z or 2026-11-28T15:30:00+01:00"));
}

nlohmann::ordered_json ToJson(const v1::StoredBackup& backup) {
  return {{"name", backup.name()},
          {"created_ns", backup.created_ns()},
          {"created", FormatTime(backup.created_ns())},
          {"bytes", backup.bytes()},
          {"revision", backup.revision()},
          {"keyframes", backup.keyframes()},
          {"archived", backup.archived()},
          {"mission_uid", backup.mission_uid()},
          {"verified_ns", backup.verified_ns()},
          {"damage", backup.damage()}};
}

std::string FormatBackups(const std::vector<v1::StoredBackup>& backups) {
  std::string text =
      absl::StrFormat("%-48s %-20s %10s %9s %9s %-32s %-20s %s\n", "backup", "made", "MiB",
                      "keyframes", "revision", "uid of the mission", "verified", "");
  for (const v1::StoredBackup& backup : backups) {
    absl::StrAppendFormat(&text, "%-48s %-20s %10.1f %9d %9d %-32s %-20s %s\n", backup.name(),
                          FormatTime(backup.created_ns()),
                          static_cast<double>(backup.bytes()) / (1 << 20), backup.keyframes(),
                          backup.revision(), backup.mission_uid(),
                          backup.verified_ns() == 0 ? "not yet" : FormatTime(backup.verified_ns()),
                          !backup.damage().empty() ? "DAMAGED: " + backup.damage()
                          : backup.archived()      ? "archive"
                                                   : "");
  }
  return text;
}

}  // namespace corbslam::services
