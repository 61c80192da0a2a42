// Keeps one RocksDB of a journal: its options, how it comes back after a write failed, and how it
// gives back what it needs no more.
#ifndef CORBSLAM_MAP_STORE_ROCKS_ROCKS_DATABASE_H_
#define CORBSLAM_MAP_STORE_ROCKS_ROCKS_DATABASE_H_

#include <rocksdb/cache.h>
#include <rocksdb/db.h>
#include <rocksdb/write_batch.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace corbslam::map_store {

// Returns a cache for all databases of a journal, so that many missions take no more than one.
std::shared_ptr<rocksdb::Cache> MakeBlockCache();

// Closes the database after a failed write and opens it again, once a second at most, when the next
// write comes: RocksDB refuses all writes after a failed one, and does not always recover by itself
// (its Resume() may go on failing when there is room again). Thread-safe.
class RocksDatabase {
 public:
  // How it is opened. What only reads writes nothing at all, and takes no lock. kSalvage does so
  // too, and takes a log up to its first damaged place; kBestEfforts writes, wants no list of files
  // that is whole, and leaves out what newer files than the lost ones hold, and all of the log.
  enum class Mode { kMake, kOpen, kOnlyRead, kSalvage, kBestEfforts };

  // `env` (not owned) may be null: then it is the system's.
  RocksDatabase(std::string directory, rocksdb::Env* env, std::shared_ptr<rocksdb::Cache> cache)
      : directory_(std::move(directory)), env_(env), cache_(std::move(cache)) {}
  ~RocksDatabase() { Close(); }

  // Removes a database that nobody has open, with all that is in it.
  static void Destroy(const std::string& directory);

  const std::string& directory() const { return directory_; }

  // Opens the database; called before all else. kMake makes it where it is not there.
  rocksdb::Status Open(Mode mode) ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends all that goes on with the files and closes them; from here on everything fails.
  void Close() ABSL_LOCKS_EXCLUDED(mutex_, tidying_);

  // Returns Corruption if something that was written before a failure is not all there; the process
  // must then be started again.
  rocksdb::Status Write(rocksdb::WriteBatch& batch, bool sync) ABSL_LOCKS_EXCLUDED(mutex_);
  rocksdb::Status SyncLog() ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns whether the last write failed.
  bool failed() const { return failed_.load(); }
  rocksdb::Status Get(const std::string& key, std::string* value) const ABSL_LOCKS_EXCLUDED(mutex_);

  // Writes anew what is still there, and removes the files that held it together with what is not:
  // it takes as much room as is there, and other writes go on. Returns Incomplete once the database
  // is closed.
  rocksdb::Status Tidy() ABSL_LOCKS_EXCLUDED(mutex_, tidying_);
  // Puts what only the log and memory hold into tables.
  rocksdb::Status Flush() ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns how many bytes that would be, about.
  uint64_t BytesInMemory() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Reads all files and compares them with their checksums.
  rocksdb::Status VerifyChecksums() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Gives the open database to `use`, which soon ends once `goes_on` says no: the database is about
  // to be closed, or to be opened again after a failure.
  using GoesOn = std::function<bool()>;
  rocksdb::Status Lend(
      const std::function<rocksdb::Status(rocksdb::DB& db, const GoesOn& goes_on)>& use) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  // Calls `visit(key, value)` for all keys from `first` on, up to `end`.
  template <typename Visit>
  absl::Status Scan(const std::string& first, const std::string& end, Visit visit) const
      ABSL_LOCKS_EXCLUDED(mutex_) {
    const std::shared_ptr<rocksdb::DB> db = Use();
    if (db == nullptr) return absl::UnavailableError("the journal is closed");
    rocksdb::ReadOptions options;
    const rocksdb::Slice bound(end);
    options.iterate_upper_bound = &bound;
    const std::unique_ptr<rocksdb::Iterator> it(db->NewIterator(options));
    for (it->Seek(first); it->Valid(); it->Next()) {
      const absl::Status visited = visit(View(it->key()), View(it->value()));
      if (!visited.ok()) return visited;
    }
    if (it->status().ok()) return absl::OkStatus();
    return absl::DataLossError(it->status().ToString());
  }

 private:
  static std::string_view View(const rocksdb::Slice& slice) { return {slice.data(), slice.size()}; }

  rocksdb::Status OpenLocked(Mode mode) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  rocksdb::Status Reopen() ABSL_LOCKS_EXCLUDED(mutex_);
  rocksdb::Status Fail(const rocksdb::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  void NoteWritten(uint64_t written);
  // The database stays open as long as the caller holds the pointer, which is null if it is closed.
  std::shared_ptr<rocksdb::DB> Use() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Reads one value by an iterator.
  static rocksdb::Status Seek(rocksdb::DB& db, const std::string& key, std::string* value);

  const std::string directory_;
  rocksdb::Env* const env_;
  const std::shared_ptr<rocksdb::Cache> cache_;

  std::atomic<bool> closing_ = false;
  // Held while the database is being tidied up.
  absl::Mutex tidying_;
  mutable absl::Mutex mutex_;
  // Null if opening the database again failed.
  std::unique_ptr<rocksdb::DB> db_ ABSL_GUARDED_BY(mutex_);
  // How many have it in use.
  mutable size_t users_ ABSL_GUARDED_BY(mutex_) = 0;
  bool only_reads_ ABSL_GUARDED_BY(mutex_) = false;
  rocksdb::Status last_failure_ ABSL_GUARDED_BY(mutex_);
  absl::Time last_try_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  std::atomic<bool> failed_ = false;
  // RocksDB's number of the newest write that succeeded.
  std::atomic<uint64_t> last_written_ = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_ROCKS_DATABASE_H_
