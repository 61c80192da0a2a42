#include "services/programs/backup_flags.h"

#include "absl/strings/str_cat.h"
#include "services/command_line/setting.h"
#include "services/programs/checks.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kLeastInterval = absl::Seconds(10);

}  // namespace

void AddBackupFlags(CLI::App& app, BackupFlags& flags) {
  AddSettings(
      app,
      {
          {"--backup-dir", &flags.directory,
           "Folder, best on another disk, for backups of all missions that the store makes by "
           "itself. Without: none"},
          {"--backup-every", &flags.every,
           "How often, as 1h or 30m; a mission that has not changed gets none"},
          {"--backup-keep", &flags.keep,
           "How many of a mission are kept; archives are kept beside them", Within(1, 100000)},
          {"--backup-mb-per-s", &flags.mb_per_s, "MB a second that backups write; 0: any",
           RareWithin(0, 100000)},
          {"--backup-take-over", &flags.take_over_from,
           "Id of the store whose folder --backup-dir was, which is gone, and whose place this "
           "one takes; the refusal names it",
           kRare},
          {"--scrub-mb-per-s", &flags.scrub_mb_per_s,
           "MB a second of the data folder, and as many of the backups, that are read again to "
           "find damage; 0: never",
           RareWithin(0, 100000)},
      });
}

absl::StatusOr<absl::Duration> ParseBackupInterval(const BackupFlags& flags) {
  absl::Duration every;
  const bool is_duration = absl::ParseDuration(flags.every, &every);
  if (is_duration && every >= kLeastInterval && every < absl::InfiniteDuration()) return every;
  return absl::InvalidArgumentError(
      absl::StrCat("--backup-every is \"", flags.every, "\", must be a time with its unit, as 1h, ",
                   "90m or 1h30m, and at least ", absl::FormatDuration(kLeastInterval)));
}

absl::Status CheckBackupFlags(const BackupFlags& flags, const std::string& data_dir) {
  RETURN_IF_ERROR(ParseBackupInterval(flags).status());
  if (flags.directory.empty()) return absl::OkStatus();
  if (data_dir.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("--backup-dir is ", flags.directory,
                     ", and there is no --data-dir: backups are made of what is on the disk"));
  }
  return CheckFolder("--backup-dir", flags.directory);
}

}  // namespace corbslam::services
