// The commands for backups that a running store keeps, and restoring of both kinds.
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "services/client/store/store_reader.h"
#include "services/convert/resource_names.h"
#include "services/tool/commands/commands.h"
#include "services/tool/commands/mission_arguments.h"
#include "services/tool/mission/backup_admin.h"
#include "services/tool/mission/file_backups.h"
#include "services/tool/mission/mission_admin.h"
#include "services/tool/mission/mission_json.h"
#include "services/tool/output/confirmation.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

void PrintBackups(const std::vector<v1::StoredBackup>& backups) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const v1::StoredBackup& backup : backups) json.push_back(ToJson(backup));
  PrintResult(FormatBackups(backups), json);
}

// Prints one backup, or `what` of it for people.
void PrintBackup(const char* what, const v1::StoredBackup& backup) {
  PrintResult(absl::StrFormat("%s: %s, %u keyframes, %.1f MiB\n", backup.name(), what,
                              backup.keyframes(), static_cast<double>(backup.bytes()) / (1 << 20)),
              ToJson(backup));
}

absl::Status StoreBackup(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  ASSIGN_OR_RETURN(const v1::StoredBackup made, BackupAdmin(channel).Store(arguments.mission));
  PrintBackup("stored", made);
  return absl::OkStatus();
}

absl::Status ListBackups(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  ASSIGN_OR_RETURN(const std::vector<v1::StoredBackup> backups,
                   BackupAdmin(channel).List(arguments.mission));
  if (backups.empty() && !arguments.mission.empty()) {
    const absl::Status known = StoreReader(channel, arguments.mission).Statistics().status();
    if (absl::IsNotFound(known)) {
      return absl::NotFoundError(absl::StrCat("the store has neither a mission ", arguments.mission,
                                              " nor a stored backup of one"));
    }
  }
  PrintBackups(backups);
  return absl::OkStatus();
}

absl::Status VerifyBackup(const MissionArguments& arguments) {
  RETURN_IF_ERROR(ParseBackupName(arguments.stored).status());
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  ASSIGN_OR_RETURN(const v1::StoredBackup found, BackupAdmin(channel).Verify(arguments.stored));
  PrintBackup("all checksums fit", found);
  return absl::OkStatus();
}

// Says what is lost with a backup, as far as the store lists it.
std::string DescribeLoss(const std::string& name, const absl::StatusOr<v1::StoredBackup>& found) {
  if (!found.ok()) return absl::StrCat(name, ", of which the store lists nothing, goes for good.");
  return absl::StrFormat(
      "%s of %s, with %u keyframes, goes for good%s.", name,
      absl::FormatTime(absl::RFC3339_sec, absl::FromUnixNanos(found->created_ns()),
                       absl::UTCTimeZone()),
      found->keyframes(), found->archived() ? ", and the mission with it: it is an archive" : "");
}

absl::Status DeleteBackup(const MissionArguments& arguments) {
  RETURN_IF_ERROR(ParseBackupName(arguments.stored).status());
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  BackupAdmin admin(channel);
  // One that is too damaged to be listed can be deleted, too.
  const absl::StatusOr<v1::StoredBackup> found = admin.Find(arguments.stored);
  if (!found.ok() && !absl::IsNotFound(found.status())) return found.status();
  RETURN_IF_ERROR(ConfirmLoss(DescribeLoss(arguments.stored, found), arguments.yes));
  ASSIGN_OR_RETURN(const v1::StoredBackup gone,
                   admin.Delete(arguments.stored, found.ok() ? found->created_ns() : 0));
  PrintBackup(gone.archived() ? "archive deleted" : "deleted", gone);
  return absl::OkStatus();
}

absl::Status Archive(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  ASSIGN_OR_RETURN(const v1::StoredBackup made, BackupAdmin(channel).Archive(arguments.mission));
  PrintBackup("archived, and deleted from the store", made);
  return absl::OkStatus();
}

// Returns INVALID_ARGUMENT where flags don't say one thing to restore and one name.
absl::Status CheckRestoreFlags(const MissionArguments& arguments) {
  const int sources = (arguments.file.empty() ? 0 : 1) + (arguments.stored.empty() ? 0 : 1) +
                      (arguments.at.empty() ? 0 : 1);
  if (sources != 1) {
    return absl::InvalidArgumentError(
        "give one of --file FILE, --stored missions/M/backups/N, or --at TIME with --mission M");
  }
  if (!arguments.at.empty() && arguments.mission.empty()) {
    return absl::InvalidArgumentError("--at wants --mission: whose backup it is");
  }
  if (!arguments.stored.empty() && !arguments.mission.empty()) {
    return absl::InvalidArgumentError(
        "--stored names its mission itself; the new one's name is --as");
  }
  if (arguments.file.empty()) return absl::OkStatus();
  if (arguments.mission.empty() == arguments.as.empty()) {
    return absl::InvalidArgumentError("--file wants the new mission's name, by --as");
  }
  return absl::OkStatus();
}

absl::StatusOr<v1::Mission> RestoreStored(const MissionArguments& arguments,
                                          const std::shared_ptr<grpc::Channel>& channel) {
  BackupAdmin admin(channel);
  std::string stored = arguments.stored;
  if (stored.empty()) {
    ASSIGN_OR_RETURN(const absl::Time at, ParseBackupTime(arguments.at));
    ASSIGN_OR_RETURN(const v1::StoredBackup found, admin.FindAt(arguments.mission, at));
    stored = found.name();
    std::fprintf(stderr, "%s of %s is restored\n", stored.c_str(),
                 absl::FormatTime(absl::RFC3339_sec, absl::FromUnixNanos(found.created_ns()),
                                  absl::UTCTimeZone())
                     .c_str());
  }
  RETURN_IF_ERROR(ParseBackupName(stored).status());
  return admin.Restore(stored, arguments.as);
}

absl::StatusOr<v1::Mission> RestoreFile(const MissionArguments& arguments,
                                        const std::shared_ptr<grpc::Channel>& channel) {
  std::error_code error;
  const uint64_t total = std::filesystem::file_size(arguments.file, error);
  return MissionAdmin(channel).Restore(arguments.file,
                                       arguments.as.empty() ? arguments.mission : arguments.as,
                                       ShowBytes("sent", error ? 0 : total));
}

absl::Status Restore(const MissionArguments& arguments) {
  RETURN_IF_ERROR(CheckRestoreFlags(arguments));
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  ASSIGN_OR_RETURN(const v1::Mission mission, arguments.file.empty()
                                                  ? RestoreStored(arguments, channel)
                                                  : RestoreFile(arguments, channel));
  PrintResult(
      absl::StrCat(mission.name(), ": ", mission.local_maps(), " local maps, ", mission.keyframes(),
                   " keyframes, ", mission.map_points(), " map points\n"),
      ToJson(mission));
  return absl::OkStatus();
}

absl::Status BackUpAllMissions(const MissionArguments& arguments) {
  ASSIGN_OR_RETURN(const auto channel, Connect(arguments));
  MissionAdmin admin(channel);
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  const auto note = [&files](const std::string& mission, const absl::StatusOr<std::string>& file) {
    const std::string text(file.ok() ? *file : std::string(file.status().message()));
    Say(absl::StrCat(mission, ": ", text, "\n"));
    files.push_back({{"mission", mission}, {file.ok() ? "file" : "error", text}});
  };
  const absl::Status status =
      BackUpAll(admin, {arguments.folder, arguments.keep}, absl::Now(), note);
  PrintResult("", files);
  return status;
}

void AddStoredFlag(CLI::App& action, MissionArguments& arguments) {
  action.add_option("--stored", arguments.stored,
                    "A stored backup, missions/M/backups/N, as `mission backups` lists it");
}

}  // namespace

void AddRestoreAction(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                      Command& chosen) {
  CLI::App* restore = AddMissionAction(mission, "restore", "Make a mission of a backup", &Restore,
                                       arguments, chosen);
  restore->add_option("--file", arguments->file, "What `mission backup` has written");
  AddStoredFlag(*restore, *arguments);
  restore->add_option("--at", arguments->at,
                      "The newest stored backup of --mission that is not newer, as "
                      "2026-11-28T14:30:00Z");
  restore->add_option("--as", arguments->as,
                      "The new mission's name, which must be free; of a stored backup the one "
                      "that it had unless said");
  restore->add_option("--mission", arguments->mission,
                      "With --at: whose backup; with --file: the same as --as");
  AddJsonFlag(*restore, *arguments);
}

void AddBackupActions(CLI::App& mission, const std::shared_ptr<MissionArguments>& arguments,
                      Command& chosen) {
  CLI::App* all = AddMissionAction(mission, "backup-all",
                                   "Write a file of each mission, DIR/MISSION/TIME.backup, and "
                                   "remove old ones; for timers",
                                   &BackUpAllMissions, arguments, chosen);
  all->add_option("--out-dir", arguments->folder, "DIR; made if it is not there")->required();
  all->add_option("--keep", arguments->keep, "Files of a mission that stay")
      ->check(CLI::Range(size_t{1}, size_t{100000}))
      ->capture_default_str();
  CLI::App* store = AddMissionAction(mission, "store-backup",
                                     "Make a backup in the store's own folder (--backup-dir)",
                                     &StoreBackup, arguments, chosen);
  AddMissionFlag(*store, *arguments);
  AddJsonFlag(*store, *arguments);
  CLI::App* list = AddMissionAction(mission, "backups", "The backups in that folder", &ListBackups,
                                    arguments, chosen);
  list->add_option("--mission", arguments->mission, "Of this mission only");
  AddJsonFlag(*list, *arguments);
  CLI::App* verify =
      AddMissionAction(mission, "verify-backup", "Read such a backup and compare its checksums",
                       &VerifyBackup, arguments, chosen);
  AddStoredFlag(*verify, *arguments);
  verify->get_option("--stored")->required();
  AddJsonFlag(*verify, *arguments);
  CLI::App* remove = AddMissionAction(mission, "delete-backup", "Remove such a backup for good",
                                      &DeleteBackup, arguments, chosen);
  AddStoredFlag(*remove, *arguments);
  remove->get_option("--stored")->required();
  AddYesFlag(*remove, *arguments);
  AddJsonFlag(*remove, *arguments);
  CLI::App* archive =
      AddMissionAction(mission, "archive",
                       "Store a backup, verify it, and delete the mission; `restore` brings it "
                       "back",
                       &Archive, arguments, chosen);
  AddMissionFlag(*archive, *arguments);
  AddJsonFlag(*archive, *arguments);
}

}  // namespace corbslam::services
