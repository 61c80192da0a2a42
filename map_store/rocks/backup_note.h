// Writes beside a stored backup what its files don't say, as lines of text: key=value.
#ifndef CORBSLAM_MAP_STORE_ROCKS_BACKUP_NOTE_H_
#define CORBSLAM_MAP_STORE_ROCKS_BACKUP_NOTE_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "map_store/records/backup_shelf.h"

namespace corbslam::map_store {

// What of a database changes with each write to it, and with nothing else.
struct DatabaseMark {
  std::string identity;   // RocksDB's, of the database.
  uint64_t sequence = 0;  // Its number of the newest write.

  bool operator==(const DatabaseMark&) const = default;
};

struct BackupNote {
  BackupFacts facts;
  // Of the mission's database right before the backup.
  DatabaseMark mark;
  uint32_t format = 0;  // The journal's.
  std::string program;  // The version of the program that made it.
};

std::string Encode(const BackupNote& note);
// Passes over keys that it doesn't know. DATA_LOSS where one that is needed is missing or no
// number.
absl::StatusOr<BackupNote> DecodeBackupNote(absl::string_view text);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_BACKUP_NOTE_H_
