// Keeps backups in a folder, with RocksDB's backup engine: those of one mission share tables and
// files of features. docs/backup.md says what is in it.
#ifndef CORBSLAM_MAP_STORE_ROCKS_BACKUP_FOLDER_H_
#define CORBSLAM_MAP_STORE_ROCKS_BACKUP_FOLDER_H_

#include <atomic>
#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "map_store/records/backup_shelf.h"
#include "map_store/rocks/backup_files.h"
#include "map_store/rocks/backup_note.h"

namespace corbslam::map_store {
class RocksJournal;

// Needs no hard links and no locks of the folder's file system, which may be a bucket that is
// mounted. One store at a time may write into a folder. Thread-safe.
class BackupFolder : public BackupShelf {
 public:
  // `journal` (not owned) must outlive it. Makes the folder. INVALID_ARGUMENT: it is within the
  // journal's folder, or the other way round. UNAVAILABLE: nothing can be written there.
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
  absl::Status Verify(absl::string_view mission, uint32_t number) const override;
  absl::StatusOr<std::unique_ptr<Journal>> Open(absl::string_view mission,
                                                uint32_t number) const override;

 private:
  using Pin = std::pair<std::string, uint32_t>;

  BackupFolder(const RocksJournal* journal, BackupOptions options)
      : journal_(journal), options_(std::move(options)) {}

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
      ABSL_LOCKS_EXCLUDED(held_mutex_);
  bool IsHeld(absl::string_view mission, uint32_t number) const ABSL_LOCKS_EXCLUDED(held_mutex_);

  const RocksJournal* const journal_;
  const BackupOptions options_;
  std::atomic<bool> interrupted_ = false;
  // Held while something is written: the engine wants one writer.
  absl::Mutex writing_;
  mutable absl::Mutex held_mutex_;
  mutable std::multiset<Pin> held_ ABSL_GUARDED_BY(held_mutex_);
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_BACKUP_FOLDER_H_
