// Keeps backups of missions as they were, in a place of its own, beside the journal that the
// missions are in.
#ifndef CORBSLAM_MAP_STORE_RECORDS_BACKUP_SHELF_H_
#define CORBSLAM_MAP_STORE_RECORDS_BACKUP_SHELF_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "map_store/records/journal.h"

namespace corbslam::map_store {

// What a backup says of the mission. The numbers are those of the moment before it was begun; what
// came while it was being made may be in it.
struct BackupFacts {
  absl::Time created = absl::UnixEpoch();
  uint64_t revision = 0;
  uint64_t keyframes = 0;
  // The mission was deleted once the backup was there.
  bool archived = false;
  // MissionState::uid; empty: the backup is older than that.
  std::string mission_uid = {};
};

struct StoredBackup {
  std::string mission;
  uint32_t number = 0;  // Grows with each backup of the mission.
  uint64_t bytes = 0;   // Files that several backups share count in each.
  BackupFacts facts;
  // When all of its files were last compared with their checksums and were right; InfinitePast:
  // never.
  absl::Time verified = absl::InfinitePast();
  std::string damage = {};  // What is damaged, and what to do; empty: nothing that is known of.
};

// What is known of how sound all backups are.
struct ShelfHealth {
  size_t damaged = 0;
  size_t unverified = 0;  // Nobody has compared them yet.
  // Of those that were, the time of the one that was compared longest ago; InfinitePast: none was.
  absl::Time oldest_verified = absl::InfinitePast();
};

// The backups of all missions, those of missions that are no more included. Errors name the folder
// or the file: NOT_FOUND (no such backup), DATA_LOSS (it is damaged), RESOURCE_EXHAUSTED (no room,
// with the numbers), FAILED_PRECONDITION (the folder is another store's), UNAVAILABLE (the disk
// refuses). Thread-safe.
class BackupShelf {
 public:
  virtual ~BackupShelf() = default;

  // Makes a backup of the mission as its journal has it now; it lasts when this returns, and all of
  // its files, those that it shares with others too, were read again and compared with their
  // checksums. A shared file that was damaged is copied anew. DATA_LOSS: the mission's journal is
  // damaged, or what was written is. ABORTED: the mission was closed meanwhile. What an attempt
  // that failed has left behind is removed.
  virtual absl::StatusOr<StoredBackup> Store(absl::string_view mission,
                                             const BackupFacts& facts) = 0;
  // Ends what is being made, and refuses more, with ABORTED: the process is about to end.
  virtual void Interrupt() = 0;
  // Returns whether nothing was written of the mission since that backup. False where there is no
  // such backup, or no such mission.
  virtual bool IsCurrent(const StoredBackup& backup) const = 0;
  // Removes the oldest backups of each mission that ever had the name beyond its newest `keep` (at
  // least 1) that are good. Archived ones, and those that are being read, stay and do not count.
  virtual absl::Status Purge(absl::string_view mission, size_t keep) = 0;
  // Removes a backup, with the files that no other one needs, whatever it is: damaged, archived,
  // the last good one. FAILED_PRECONDITION: it is being read.
  virtual absl::Status Remove(absl::string_view mission, uint32_t number) = 0;

  // Returns the missions that have backups, by name.
  virtual absl::StatusOr<std::vector<std::string>> ListMissions() const = 0;
  // Returns the mission's backups that are good as far as their lists of files tell, the oldest
  // first.
  virtual absl::StatusOr<std::vector<StoredBackup>> List(absl::string_view mission) const = 0;
  virtual absl::StatusOr<StoredBackup> Find(absl::string_view mission, uint32_t number) const = 0;
  // Compares the files of all backups of the mission with their checksums, each file once, and
  // remembers what came of it (StoredBackup::verified, damage). Asks `pace` before each piece that
  // it reads. CANCELLED: `pace` said no.
  virtual absl::Status Compare(absl::string_view mission,
                               const std::function<bool(uint64_t bytes)>& pace) = 0;
  virtual ShelfHealth health() const = 0;
  // Reads all files of the backup and compares them, and all that is in them, with their checksums.
  virtual absl::Status Verify(absl::string_view mission, uint32_t number) const = 0;
  // Opens a backup as a journal that has the one mission, under the name that it had, and takes
  // nothing in. The shelf must outlive it.
  virtual absl::StatusOr<std::unique_ptr<Journal>> Open(absl::string_view mission,
                                                        uint32_t number) const = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_BACKUP_SHELF_H_
