#include "services/map_store_service/stored_backup_message.h"

#include "services/convert/resource_names.h"

namespace corbslam::services {

void ToProto(const map_store::StoredBackup& backup, v1::StoredBackup* proto) {
  proto->set_name(BackupName(backup.mission, backup.number));
  proto->set_created_ns(absl::ToUnixNanos(backup.facts.created));
  proto->set_bytes(backup.bytes);
  proto->set_revision(backup.facts.revision);
  proto->set_keyframes(backup.facts.keyframes);
  proto->set_archived(backup.facts.archived);
  proto->set_mission_uid(backup.facts.mission_uid);
  if (backup.verified != absl::InfinitePast()) {
    proto->set_verified_ns(absl::ToUnixNanos(backup.verified));
  }
  proto->set_damage(backup.damage);
}

absl::Status CheckKeepsBackups(const map_store::StoredBackups* backups) {
  if (backups != nullptr) return absl::OkStatus();
  return absl::FailedPreconditionError(
      "this store has no folder of backups: start it with --backup-dir (and --data-dir), or use "
      "BackupMission, which writes one file (`corbslam mission backup`)");
}

}  // namespace corbslam::services
