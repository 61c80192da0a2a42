// Keeps the RocksDB of a journal: its options, and how it comes back after a write failed.
#ifndef CORBSLAM_MAP_STORE_ROCKS_ROCKS_DATABASE_H_
#define CORBSLAM_MAP_STORE_ROCKS_ROCKS_DATABASE_H_

#include <rocksdb/db.h>
#include <rocksdb/write_batch.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace corbslam::map_store {

// Closes the database after a failed write and opens it again, once a second at most, when the next
// write comes: RocksDB refuses all writes after a failed one, and does not always recover by itself
// (its Resume() may go on failing when there is room again). Thread-safe.
class RocksDatabase {
 public:
  // `env` (not owned) may be null: then it is the system's.
  RocksDatabase(std::string directory, rocksdb::Env* env)
      : directory_(std::move(directory)), env_(env) {}

  // Opens the database; called before all else.
  rocksdb::Status Open() ABSL_LOCKS_EXCLUDED(mutex_);

  // Returns Corruption if something that was written before a failure is not all there; the process
  // must then be started again.
  rocksdb::Status Write(rocksdb::WriteBatch& batch, bool sync) ABSL_LOCKS_EXCLUDED(mutex_);
  rocksdb::Status SyncLog() ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns whether the last write failed.
  bool failed() const { return failed_.load(); }
  rocksdb::Status Get(const std::string& key, std::string* value) const ABSL_LOCKS_EXCLUDED(mutex_);

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

  rocksdb::Status OpenLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  rocksdb::Status Reopen() ABSL_LOCKS_EXCLUDED(mutex_);
  rocksdb::Status Fail(const rocksdb::Status& status) ABSL_LOCKS_EXCLUDED(mutex_);
  void NoteWritten(uint64_t written);
  // The database stays open as long as the caller holds the pointer.
  std::shared_ptr<rocksdb::DB> Use() const ABSL_LOCKS_EXCLUDED(mutex_) {
    absl::MutexLock lock(&mutex_);
    return db_;
  }

  const std::string directory_;
  rocksdb::Env* const env_;

  mutable absl::Mutex mutex_;
  // Null if opening the database again failed.
  std::shared_ptr<rocksdb::DB> db_ ABSL_GUARDED_BY(mutex_);
  rocksdb::Status last_failure_ ABSL_GUARDED_BY(mutex_);
  absl::Time last_try_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  std::atomic<bool> failed_ = false;
  // RocksDB's number of the newest write that succeeded.
  std::atomic<uint64_t> last_written_ = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_ROCKS_DATABASE_H_
