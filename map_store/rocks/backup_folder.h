// Keeps backups in a folder, with RocksDB's backup engine: those of one mission share tables and
// files of features. docs/backup.md says what is in it.
#ifndef CORBSLAM_MAP_STORE_ROCKS_BACKUP_FOLDER_H_
#define CORBSLAM_MAP_STORE_ROCKS_BACKUP_FOLDER_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "map_store/records/backup_shelf.h"
#include "map_store/rocks/backup_files.h"
#include "map_store/rocks/backup_health.h"
#include "map_store/rocks/backup_note.h"
#include "map_store/rocks/backup_sums.h"

namespace corbslam::map_store {
class RocksJournal;

// Needs no hard links and no locks of the folder's file system, which may be a bucket that is
// mounted. One store writes into a folder, whose id stands in it (backup_owner.h). Thread-safe.
class BackupFolder : public BackupShelf {
 public:
  // `journal` (not owned) must outlive it. Makes the folder. INVALID_ARGUMENT: it is within the
  // journal's folder, or the other way round. FAILED_PRECONDITION: it is another store's.
  // UNAVAILABLE: nothing can be written there.
  static absl::StatusOr<std::unique_ptr<BackupFolder>> Open(const RocksJournal* journal,
                                                            const BackupOptions& options);

  absl::StatusOr<StoredBackup> Store(absl::string_view mission, const BackupFacts& facts) override;
  void Interrupt() override { interrupted_ = true; }
  bool IsCurrent(const StoredBackup& backup) const override;
  absl::Status Purge(absl::string_view mission, size_t keep) override;
  absl::Status Remove(absl::string_view mission, uint32_t number) override;
  absl::StatusOr<std::vector<std::string>> ListMissions() const override;
  absl::StatusOr<std::vector<StoredBackup>> List(absl::string_view mission) const override;
  absl::StatusOr<StoredBackup> Find(absl::string_view mission, uint32_t number) const override;
  absl::Status Compare(absl::string_view mission,
                       const std::function<bool(uint64_t bytes)>& pace) override;
  ShelfHealth health() const override ABSL_LOCKS_EXCLUDED(health_mutex_);
  absl::Status Verify(absl::string_view mission, uint32_t number) const override;
  absl::StatusOr<std::unique_ptr<Journal>> Open(absl::string_view mission,
                                                uint32_t number) const override;

 private:
  using BackupInUse = std::pair<std::string, uint32_t>;

  BackupFolder(const RocksJournal* journal, BackupOptions options, std::string store_id)
      : journal_(journal), options_(std::move(options)), store_id_(std::move(store_id)) {}
  // Returns FAILED_PRECONDITION if another store has taken the folder over.
  absl::Status CheckOwner() const;
  void LoadHealth() ABSL_LOCKS_EXCLUDED(health_mutex_);
  // Puts what is known of the backup into it.
  void AddHealth(StoredBackup& backup) const ABSL_LOCKS_EXCLUDED(health_mutex_);
  void NoteHealth(absl::string_view mission, uint32_t number, const absl::Status& compared) const
      ABSL_LOCKS_EXCLUDED(health_mutex_);
  void ForgetHealth(absl::string_view mission, uint32_t number) const
      ABSL_LOCKS_EXCLUDED(health_mutex_);
  std::vector<uint32_t> ListNumbers(absl::string_view mission) const
      ABSL_LOCKS_EXCLUDED(health_mutex_);
  bool IsDamaged(absl::string_view mission, uint32_t number) const
      ABSL_LOCKS_EXCLUDED(health_mutex_);
  // Compares a backup that was just made, and mends what it shares with others.
  absl::Status CompareNew(rocksdb::DB& db, absl::string_view mission, uint32_t number,
                          const std::function<bool()>& goes_on) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writing_);
  // Puts a copy of the database's own file in the place of a damaged one that backups share. A
  // compaction may have taken the file meanwhile: then the next backup does without it.
  absl::Status Mend(rocksdb::DB& db, absl::string_view mission, const SummedFile& file,
                    const BackupPace& pace) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(writing_);

  std::string FolderOf(absl::string_view mission) const;
  std::string PlaceOf(absl::string_view mission, uint32_t number) const;
  // Returns what the engine knows of a backup, with its files.
  absl::StatusOr<rocksdb::BackupInfo> ReadInfo(const rocksdb::BackupEngineReadOnlyBase& engine,
                                               absl::string_view mission, uint32_t number) const;
  // Returns whether the mission still is that whose archive this would be.
  bool IsStillThere(absl::string_view mission, const BackupNote& note) const;
  // Makes the backup, and says its number.
  absl::StatusOr<uint32_t> Write(rocksdb::BackupEngine& engine, absl::string_view mission,
                                 const BackupFacts& facts) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(writing_);
  // Keeps the backup from being removed as long as the result lives.
  std::shared_ptr<const void> Hold(absl::string_view mission, uint32_t number) const
      ABSL_LOCKS_EXCLUDED(in_use_mutex_);
  bool IsInUse(absl::string_view mission, uint32_t number) const ABSL_LOCKS_EXCLUDED(in_use_mutex_);

  const RocksJournal* const journal_;
  const BackupOptions options_;
  const std::string store_id_;
  std::atomic<bool> interrupted_ = false;
  // Held while something is written: the engine wants one writer.
  absl::Mutex writing_;
  mutable absl::Mutex health_mutex_;
  // Of all backups that there are, by their missions.
  mutable std::map<std::string, HealthByNumber, std::less<>> health_ ABSL_GUARDED_BY(health_mutex_);
  mutable absl::Mutex in_use_mutex_;
  mutable std::multiset<BackupInUse> in_use_ ABSL_GUARDED_BY(in_use_mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_BACKUP_FOLDER_H_
