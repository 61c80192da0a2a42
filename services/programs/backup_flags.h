// Flags of what a map store does by itself to keep missions safe.
#ifndef CORBSLAM_SERVICES_PROGRAMS_BACKUP_FLAGS_H_
#define CORBSLAM_SERVICES_PROGRAMS_BACKUP_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"

namespace corbslam::services {

struct BackupFlags {
  std::string directory;  // Empty: none are stored.
  std::string every = "1h";
  size_t keep = 24;
  double mb_per_s = 32;
  // The id of the store whose folder it was; empty: none.
  std::string take_over_from;
  double scrub_mb_per_s = 1;
};

// Adds --backup-dir and those that go with it. The flags must outlive the parsing.
void AddBackupFlags(CLI::App& app, BackupFlags& flags);

// Returns INVALID_ARGUMENT, naming the flag, the value and what is wanted.
absl::StatusOr<absl::Duration> ParseBackupInterval(const BackupFlags& flags);
// Checks them against the store's folder of data (empty: none).
absl::Status CheckBackupFlags(const BackupFlags& flags, const std::string& data_dir);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_BACKUP_FLAGS_H_
