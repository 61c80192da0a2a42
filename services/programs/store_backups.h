// Puts together what a map store's program does to keep missions safe.
#ifndef CORBSLAM_SERVICES_PROGRAMS_STORE_BACKUPS_H_
#define CORBSLAM_SERVICES_PROGRAMS_STORE_BACKUPS_H_

#include <prometheus/collectable.h>

#include <memory>

#include "absl/status/statusor.h"
#include "map_store/process/backup_keeper.h"
#include "map_store/process/backup_verifier.h"
#include "map_store/rocks/rocks_journal.h"
#include "map_store/store/map_store.h"
#include "map_store/store/stored_backups.h"
#include "services/programs/backup_flags.h"

namespace corbslam::services {

// Backups of one store, and the thread that makes them. One thread uses it.
class StoreBackups {
 public:
  // Neither is owned, and both must outlive it; `journal` is null where missions are in memory
  // only, and without --backup-dir there are no backups either. Errors name the flag.
  static absl::StatusOr<std::unique_ptr<StoreBackups>> Make(const BackupFlags& flags,
                                                            map_store::MapStore* store,
                                                            const map_store::RocksJournal* journal);

  // Null: there are none.
  map_store::StoredBackups* backups() { return backups_.get(); }
  // Begins to make backups.
  void Start();
  // Counts them, for metrics; it must go before this does.
  std::shared_ptr<prometheus::Collectable> MakeCollector() const;
  // Gives up the backup that is being made, and ends the thread.
  void Stop();

 private:
  explicit StoreBackups(const map_store::RocksJournal* journal) : journal_(journal) {}

  const map_store::RocksJournal* const journal_;
  absl::Duration every_;
  std::unique_ptr<map_store::StoredBackups> backups_;
  // Declared last, so that their threads end first.
  std::unique_ptr<map_store::BackupVerifier> verifier_;
  std::unique_ptr<map_store::BackupKeeper> keeper_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_STORE_BACKUPS_H_
