// Makes backups of a store's missions on a shelf, and missions of such backups.
#ifndef CORBSLAM_MAP_STORE_STORE_STORED_BACKUPS_H_
#define CORBSLAM_MAP_STORE_STORE_STORED_BACKUPS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "map_store/records/backup_shelf.h"
#include "map_store/state/lookups.h"
#include "map_store/store/map_store.h"

namespace corbslam::map_store {

// Errors are BackupShelf's, unless something else is said. Thread-safe.
class StoredBackups {
 public:
  // `store` is not owned and must outlive it. `keep`: how many backups of a mission stay, at least
  // 1; archived ones don't count.
  StoredBackups(MapStore* store, std::unique_ptr<BackupShelf> shelf, size_t keep,
                MapStore::Clock clock);

  // Makes a backup of the mission, and removes the oldest ones beyond those that are kept.
  absl::StatusOr<StoredBackup> Store(const std::string& mission);
  // Does so, unless the newest one is younger than `least_age` or nothing was written since.
  // Returns whether it did.
  absl::StatusOr<bool> StoreIfChanged(const std::string& mission, absl::Duration least_age);

  // Returns backups of one mission, or of all (empty name), by mission, then by number.
  absl::StatusOr<Page<StoredBackup>> List(absl::string_view mission,
                                          const PageRequest& request) const;
  // Does what BackupShelf::Interrupt does.
  void Interrupt() { shelf_->Interrupt(); }
  // Compares all backups with their checksums, each file once (BackupShelf::Compare).
  absl::Status CompareAll(const std::function<bool(uint64_t bytes)>& pace);
  ShelfHealth health() const { return shelf_->health(); }
  // Compares all of it with its checksums.
  absl::StatusOr<StoredBackup> Verify(const std::string& mission, uint32_t number) const;
  // Removes one for good, whatever it is (BackupShelf::Remove), and returns what it was; of one
  // whose list of files is damaged, its name alone. FAILED_PRECONDITION: it was not made at
  // `created`, but the number was given again.
  absl::StatusOr<StoredBackup> Remove(const std::string& mission, uint32_t number,
                                      std::optional<absl::Time> created);
  // Makes a mission of the backup, under any name that is free, as MapStore::RestoreMission does
  // and with its errors.
  absl::Status Restore(const std::string& mission, uint32_t number, const std::string& name);
  // Makes a backup, verifies it and reads it back, and deletes the mission. FAILED_PRECONDITION,
  // with nothing changed: robots are connected, or something was written meanwhile.
  absl::StatusOr<StoredBackup> Archive(const std::string& mission);

 private:
  // Returns whether the mission sleeps and is what the backup holds, as far as its summary tells:
  // there is no need to open its database.
  bool SleepsAsStored(const std::string& mission, const StoredBackup& backup) const;
  absl::StatusOr<BackupFacts> FactsOf(const std::string& mission) const;
  // Reads the backup as a start would, without features, and compares it with what it should hold.
  absl::Status CheckReadsBack(const StoredBackup& backup) const;
  absl::Status DeleteArchived(const StoredBackup& backup);

  MapStore& store_;
  const std::unique_ptr<BackupShelf> shelf_;
  const size_t keep_;
  const MapStore::Clock clock_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_STORE_STORED_BACKUPS_H_
